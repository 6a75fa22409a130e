"""Virtual test rigs: one wheel on a carriage, and the whole tractor pulled, on a slope, parked.

The laws are asked only through MuJoCo's callback, so a rig measures a soil law it has never heard
of. Each rig is a function that returns arrays.
"""
