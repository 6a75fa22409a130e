"""Gymnasium environments of the twin; importing this package registers them.

    env = gymnasium.make("twin.env:Plough-v1")
    many = gymnasium.make_vec(
        "twin.env:Plough-v1", num_envs=256, vectorization_mode="vector_entry_point"
    )

Plough-v1     actions: throttle, gear, depth, draft mix. Reward: area and fuel, within limits
WheelSlip-v1  actions: torque or speed of both rear wheels. Reward: speed and energy, along a slope
Plough-v0     superseded. Actions: throttle, depth. Reward: slip, depth and work rate at targets
WheelSlip-v0  superseded. Actions: torque of both rear wheels. Reward: slip at a target, no sideslip

The machine of Plough is a ploughing tractor, that of WheelSlip an electric one that tows a
cultivator.

Each is also registered in the namespace of the package: `twin.env:tractor_twin/Plough-v0`.
"""

from gymnasium import register, spec

IDS = ("Plough-v0", "WheelSlip-v0", "Plough-v1", "WheelSlip-v1")

register(
    id="Plough-v0",
    entry_point="twin.env.plough:PloughEnv",
    vector_entry_point="twin.env.vector:PloughVectorEnv",
    max_episode_steps=1500,
)
register(
    id="WheelSlip-v0",
    entry_point="twin.env.wheel_slip:WheelSlipEnv",
    vector_entry_point="twin.env.vector:WheelSlipVectorEnv",
    max_episode_steps=1000,
)
register(
    id="Plough-v1",
    entry_point="twin.env.plough_field:PloughFieldEnv",
    vector_entry_point="twin.env.vector:PloughFieldVectorEnv",
    max_episode_steps=1500,
)
register(
    id="WheelSlip-v1",
    entry_point="twin.env.slip_line:SlipLineEnv",
    vector_entry_point="twin.env.vector:SlipLineVectorEnv",
    max_episode_steps=1000,
)

NAMESPACE = "tractor_twin"

for _plain in map(spec, IDS):
    register(
        id=f"{NAMESPACE}/{_plain.id}",
        entry_point=_plain.entry_point,
        vector_entry_point=_plain.vector_entry_point,
        max_episode_steps=_plain.max_episode_steps,
    )
