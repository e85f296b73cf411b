"""What one step of each integer at the network's door is worth."""
ZERO = 64  # the byte of 0.0
HIGH = 127  # bytes are 0..127: no instruction set's 8-bit products overflow on them
FOCUS = 1 / 8  # a step of normalised sharpness, in standard deviations
CONTEXT = 1 / 32  # a step of every context channel
