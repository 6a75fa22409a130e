"""What finds named signals in a file, one module for each kind of file."""
