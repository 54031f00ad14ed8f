"""Questions that people ask: pure functions of scenes, paths and measured numbers."""
