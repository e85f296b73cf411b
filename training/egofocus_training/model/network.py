"""The whole network: what a config makes of the stages, and what comes out of them."""
from dataclasses import dataclass

import torch
from torch import nn

from ..focus_input import context_channels
from ..units import CONTEXT, FOCUS, ZERO
from .aggregation import CrossScaleAggregation
from .fcd import FeatureFocusCost, FocusCost
from .feature_pyramid import FeaturePyramid
from .ihca import InterHypothesisBlock
from .refinement import Refinement
from .regression import confidence, distribution, expected_index, median_index

_STACK_SCALE = 1 / 4  # published order: one fixed scale of the counts, saturating at 15


@dataclass
class Prediction:
    """Indices are in hypotheses of the window's ladder."""
    scores: torch.Tensor  # [B, D, h / 4, w / 4]
    coarse: torch.Tensor  # scores at 1/8 [B, D, ...]; None outside training
    index_4: torch.Tensor  # [B, h / 4, w / 4], before refinement
    index: torch.Tensor  # [B, h / 2, w / 2]
    confidence: torch.Tensor  # [B, h / 4, w / 4] 0..1


class FocusNetwork(nn.Module):
    """Inputs, a dict of tensors: focus u8 [B, D, maps, h/4, w/4], context u8 [B, n, h/4, w/4], half u8 [B, D, h/2, w/2],
    used int64 [B]: hypotheses of the ladder; published order: counts u8 [B, D, h, w] in place of focus."""

    def __init__(self, input_config, config):
        super().__init__()
        self.hypotheses = depth = input_config.hypotheses
        self.published = config.order == "published"
        self.median = config.regression == "median"
        if self.published:
            self.features = FeaturePyramid(depth, config.stem, config.widths, config.blocks)
            self.fcd = FeatureFocusCost(config.cost_channels)
        else:
            self.fcd = FocusCost(len(input_config.maps), config.cost_hidden, config.cost_channels)
        self.ihca = nn.Sequential(*(InterHypothesisBlock(self.fcd.channels) for _ in range(config.ihca_blocks)))
        self.aggregation = CrossScaleAggregation(depth, self.fcd.channels, context_channels(input_config),
                                                 config.widths, config.blocks, config.up_blocks)
        self.regression = distribution
        self.refinement = Refinement(depth, config.widths[0], config.refine_width, config.refine_dilations)

    def forward(self, inputs):
        context = (inputs["context"].float() - ZERO) * CONTEXT
        if self.published:
            stack = inputs["counts"].float().clamp(max=15) * _STACK_SCALE
            cost = self.fcd(self.features(stack))
        else:
            cost = self.fcd((inputs["focus"].float() - ZERO) * FOCUS)
        cost = self.ihca(cost)
        scores, coarse, features = self.aggregation(cost, context)
        p = self.regression(scores, inputs["used"])
        index_4 = median_index(p, inputs["used"]) if self.median else expected_index(p)
        index = self.refinement(index_4, inputs["half"], features, inputs["used"])
        with torch.no_grad():
            trust = confidence(p, index_4, context[:, -2])
        return Prediction(scores, coarse, index_4, index, trust)

    def one_scale(self):
        """Lists of Bytes that share a scale."""
        costs = [[self.fcd.filter[-1][-1], *(block.sum for block in self.ihca)]] if len(self.ihca) else []
        return costs + self.aggregation.one_scale() + self.refinement.one_scale()

    def cost_scale(self):
        """Of the bytes of C."""
        return (self.ihca[-1].sum if len(self.ihca) else self.fcd.filter[-1][-1]).scale
