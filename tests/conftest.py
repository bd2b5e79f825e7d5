"""How deep the tests look at random: a little in every run, and much in ``.ci/deep`` (``support.depth``)."""

from hypothesis import settings

settings.register_profile("ci", deadline=None, derandomize=True)
settings.register_profile("deep", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile("ci")  # before --hypothesis-profile is read
