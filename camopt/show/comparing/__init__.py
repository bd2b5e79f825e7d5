"""Two results side by side: designs that came, went or changed, fronts, settings; two cams by quantities."""
