#include "eval_curve.hpp"

#include <algorithm>
#include <vector>

#include "recording/number_text.hpp"

namespace egofocus::app {
namespace {

using recording::fixed_text;
using recording::MethodScore;
using recording::SparsificationCurve;

constexpr double kWidth = 640;
constexpr double kHeight = 400;
constexpr double kLeft = 60;
constexpr double kRight = 620;
constexpr double kTop = 20;
constexpr double kBottom = 350;
constexpr const char* kColours[] = {"#2458a6", "#c0392b", "#2e8b57", "#8e44ad"};

/// From share removed and error to the page.
struct Axes {
  double highest;
  [[nodiscard]] double x(double share) const { return kLeft + (kRight - kLeft) * share; }
  [[nodiscard]] double y(double error) const { return kBottom - (kBottom - kTop) * error / highest; }
};

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + fixed_text(x1, 1) + "\" y1=\"" + fixed_text(y1, 1) + "\" x2=\"" + fixed_text(x2, 1) +
         "\" y2=\"" + fixed_text(y2, 1) + "\" " + style + "/>\n";
}

std::string text(double x, double y, const std::string& words, const char* anchor = "middle") {
  return "<text x=\"" + fixed_text(x, 1) + "\" y=\"" + fixed_text(y, 1) + "\" text-anchor=\"" + anchor +
         "\">" + words + "</text>\n";
}

std::string curve(const Axes& axes, const SparsificationCurve& values, const std::string& style) {
  std::string points;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(values.size());
    points += fixed_text(axes.x(share), 1) + "," + fixed_text(axes.y(values[k]), 1) + " ";
  }
  return "<polyline fill=\"none\" points=\"" + points + "\" " + style + "/>\n";
}

std::string grid(const Axes& axes) {
  std::string out;
  for (int i = 0; i <= 4; ++i) {
    const double error = axes.highest * i / 4;
    out += line(kLeft, axes.y(error), kRight, axes.y(error), "stroke=\"#ddd\"");
    out += text(kLeft - 6, axes.y(error) + 4, fixed_text(error, 3), "end");
    out += text(axes.x(0.25 * i), kBottom + 18, std::to_string(25 * i) + " %");
  }
  out += text((kLeft + kRight) / 2, kBottom + 40, "removed, least confident first (dashed: worst first)");
  return out + text(kLeft, kTop - 6, "abs_rel of the rest");
}

}  // namespace

std::string curve_svg(const recording::SequenceScore& score) {
  std::vector<const MethodScore*> methods;
  double highest = 0;
  for (const MethodScore& method : score.methods) {
    if (method.sparsification.images() == 0) continue;
    methods.push_back(&method);
    const SparsificationCurve values = method.sparsification.mean().by_confidence;
    highest = std::max(highest, *std::max_element(values.begin(), values.end()));
  }
  const Axes axes{highest > 0 ? highest * 1.05 : 1.0};
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + fixed_text(kWidth, 0) + " " +
                    fixed_text(kHeight, 0) + "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
                    "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + grid(axes);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const std::string stroke =
        "stroke=\"" + std::string(kColours[i % std::size(kColours)]) + "\" stroke-width=\"2\"";
    const recording::Sparsification mean = methods[i]->sparsification.mean();
    const double y = kTop + 16 + 18 * static_cast<double>(i);
    out += curve(axes, mean.by_confidence, stroke) +
           curve(axes, mean.by_oracle, stroke + " stroke-dasharray=\"5 4\"") +
           line(kRight - 130, y - 4, kRight - 106, y - 4, stroke) +
           text(kRight - 100, y, methods[i]->method, "start");
  }
  return out + "</svg>\n";
}

}  // namespace egofocus::app
