"""tractor-twin: a physics-simulated digital twin of a tractor and plough."""
