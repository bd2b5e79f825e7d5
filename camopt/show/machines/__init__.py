"""Pictures of machines: the timing diagram of all stations, and all cams turning together."""
