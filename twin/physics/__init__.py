"""The tyre-soil and plough laws and the C callback that runs them inside MuJoCo."""
