"""Training of egofocus's depth network: samples of citysim in, weights out. README.md is one folder up."""
