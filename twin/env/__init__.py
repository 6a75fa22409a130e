"""Gymnasium environments of the twin; importing this package registers them.

    env = gymnasium.make("twin.env:Plough-v0")
    many = gymnasium.make_vec(
        "twin.env:Plough-v0", num_envs=256, vectorization_mode="vector_entry_point"
    )

Plough-v1     throttle, gear and hitch of a ploughing tractor, for area and fuel within limits
Plough-v0     throttle and hitch depth of a ploughing tractor, for slip, depth and work rate
WheelSlip-v1  motors of both rear wheels, for speed and energy along a line across a slope
WheelSlip-v0  torque of each rear wheel of an electric tractor that pulls, for slip and sideslip

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
