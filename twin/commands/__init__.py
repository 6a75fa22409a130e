"""The subcommands of `twin`, one module each with `main(args) -> exit status`."""
