"""What the tests share: independent answers, hostile and random scenes, checks of pictures."""
