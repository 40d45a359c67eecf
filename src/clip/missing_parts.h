// What a damaged clip lacks, as phrases about layers and times.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace kinora::clip {

/// "frames 12 to 17 (0.40 to 0.57 s) and frame 40 (1.33 s)": those of `there` that are false. The first three runs, and
/// how many more frames. `times` are the frames', seconds.
std::string missing_frames(const std::vector<bool>& there, std::span<const double> times);

/// One sentence for a person: "NAME is damaged; missing: A; B; kinora validate says where".
std::string missing_sentence(const std::string& name, std::span<const std::string> missing);

} // namespace kinora::clip
