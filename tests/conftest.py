"""Settings of all tests."""

from hypothesis import settings

# The same examples in every run: a change of the code is what makes a test fail, not the day. Who
# hunts for new ones runs `pytest --hypothesis-profile=default`.
settings.register_profile("same", derandomize=True, database=None, deadline=None)
settings.load_profile("same")
