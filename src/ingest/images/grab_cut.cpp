#include "ingest/images/grab_cut.h"

namespace kinora::ingest {

std::vector<std::uint8_t> labels_in(const LabelImage& labels) {
  std::array<bool, 256> seen{};
  for (const std::uint8_t label : labels.values()) seen[label] = true;
  std::vector<std::uint8_t> list;
  for (std::size_t label = 1; label < seen.size(); ++label)
    if (seen[label]) list.push_back(static_cast<std::uint8_t>(label));
  return list;
}

Mask inner_pixels(const LabelImage& labels, int radius) { return opencv_functions().inner_pixels(labels, radius); }

ColorMixtures::ColorMixtures(const ColorImage& color, const LabelImage& labels, std::uint8_t label) {
  opencv_functions().learn_mixtures(color, labels, label, foreground_, background_);
}

Mask ColorMixtures::cut(const ColorImage& color, const Image<Trimap>& known) const {
  Mask mask(known.width(), known.height());
  std::ranges::transform(known.values(), mask.data(), [](Trimap b) { return static_cast<std::uint8_t>(b); });
  opencv_functions().cut(color, foreground_, background_, mask);
  for (std::uint8_t& state : mask.values()) state &= 1; // kForeground and kProbableForeground are odd
  return mask;
}

void sharpen_borders(const ColorImage& color, int radius, LabelImage& labels) {
  opencv_functions().sharpen_borders(color, radius, labels_in(labels), labels);
}

} // namespace kinora::ingest
