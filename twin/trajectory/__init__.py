"""What a drive leaves: noise-free quantities on the physics grid, and how it ended."""
