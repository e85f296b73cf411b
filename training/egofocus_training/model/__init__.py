"""The network's stages, one module each, in the order they run (network.py puts them together).

Operators: convolutions (1x1, 3x3, strided, dilated, depthwise), batch norm that folds into them, ReLU, addition,
bilinear up-sampling by 2, gathering, softmax over hypotheses. Each has an int8 form: no deformable convolution, no
group norm, no learned up-sampling.
"""
