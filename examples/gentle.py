"""A controller: lifts the plough in proportion to the slip above its target."""

from twin.control.controllers import hitch_action


class Gentle:
    def init(self, setup):
        return setup.period_s, 0.0  # the state: time step [s], smoothed slip

    def act(self, state, observation):
        period_s, slip = state
        slip += period_s / 0.2 * (observation["slip"] - slip)
        above = max(0.0, slip - observation["slip_target"])
        depth_set_m = observation["depth_target_m"] - 0.5 * above
        return (period_s, slip), (0.2, hitch_action(depth_set_m))  # throttle, hitch
