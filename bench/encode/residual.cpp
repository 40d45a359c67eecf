// Hybrid deformation: what a person's motion gains from corrections of its nodes by what its field shows, and from a
// net that tells corrections by the pose (residual_net.h):
//   bench_residual CAPTURE [SEEDS]        (default: 1 seed; a synthetic capture)
// - none: as tracked, smoothed;
// - nodes: corrected frame by frame (encode/motion_refinement.h);
// - net: corrected by a net that was trained on the corrections of the row before;
// - net, nodes: corrected frame by frame after that.
// Prints means: PSNR of everything that is labelled over its box, in frames of the capture that were tracked and not
// trained on (every tenth), and from the truth's other cameras, there also within the silhouette; seen points' error;
// and how far nodes and net displace (mm, median) in frames that are trained on, and the net's difference to the nodes.
#include <cstdio>
#include <cstdlib>

#include "core/statistics.h"
#include "encode/capture_preparation.h"
#include "encode/layer_presence.h"
#include "encode/layer_training.h"
#include "encode/node_correction.h"
#include "encode/training_plan.h"
#include "host/plugin_table.h"
#include "residual_net.h"
#include "truth_measures.h"

namespace {

using namespace kinora;
using Deformations = std::vector<motion::Motion::Deformation>;

/// 24 joints in the frame of the first one's place, as the parts of a pose.
Eigen::RowVectorXf pose_of(const std::vector<Eigen::Vector3d>& joints) {
  Eigen::RowVectorXf pose = Eigen::RowVectorXf::Zero(72);
  for (std::size_t j = 0; j < std::min<std::size_t>(joints.size(), 24); ++j)
    pose.segment<3>(3 * static_cast<Eigen::Index>(j)) = (joints[j] - joints[0]).cast<float>().transpose();
  return pose;
}

struct Displacements {
  double nodes = 0; ///< metres, medians
  double net = 0;
  double difference = 0;
};

/// The tracked motion with what the net, trained on `refined` where frames are stored, says of all frames.
motion::Motion corrected_by_net(const motion::Motion& tracked, const motion::Motion& refined,
                                const motion::JointPaths& joints, const fields::PixelStore& pixels, unsigned seed,
                                Displacements& found) {
  const auto& nodes = tracked.graph()->nodes();
  const auto count = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXf places(count, bench::ResidualNet::kPlace);
  for (Eigen::Index n = 0; n < count; ++n)
    places.row(n) = bench::ResidualNet::encoded(nodes[static_cast<std::size_t>(n)]);
  const auto inputs_at = [&](std::size_t f) {
    Eigen::MatrixXf inputs(count, bench::ResidualNet::kInputs);
    inputs << places, pose_of(joints.positions[f]).replicate(count, 1);
    return inputs;
  };
  const std::vector<fields::StoredFrame>& frames = pixels.frames();
  Eigen::MatrixXf inputs(count * static_cast<Eigen::Index>(frames.size()), bench::ResidualNet::kInputs);
  Eigen::MatrixXf targets(inputs.rows(), 3);
  std::vector<double> sizes;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto f = static_cast<std::size_t>(frames[k].frame);
    const Eigen::Index row = count * static_cast<Eigen::Index>(k);
    inputs.middleRows(row, count) = inputs_at(f);
    for (Eigen::Index n = 0; n < count; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const Twist correction = encode::correction_of(nodes[i], tracked.deformations()[f].node_to_world[i],
                                                     refined.deformations()[f].node_to_world[i]);
      targets.row(row + n) = correction.head<3>().cast<float>().transpose();
      sizes.push_back(correction.head<3>().norm());
    }
  }
  const Eigen::RowVectorXf mean = inputs.colwise().mean();
  const Eigen::RowVectorXf spread =
      ((inputs.rowwise() - mean).colwise().squaredNorm() / static_cast<float>(inputs.rows())).cwiseSqrt().array() +
      1e-3F;
  const auto normalised = [&](const Eigen::MatrixXf& raw) -> Eigen::MatrixXf {
    return ((raw.rowwise() - mean).array().rowwise() / spread.array()).matrix();
  };
  found.nodes = median(sizes);
  const auto scale = static_cast<float>(found.nodes);
  bench::ResidualNet net(seed);
  inputs = normalised(inputs);
  net.train(inputs, targets, scale, 2000);
  const Eigen::MatrixXf told = net.displacements(inputs);
  std::vector<double> net_sizes, differences;
  for (Eigen::Index i = 0; i < told.rows(); ++i) {
    net_sizes.push_back(told.row(i).norm());
    differences.push_back((told.row(i) - targets.row(i)).norm());
  }
  found.net = median(net_sizes);
  found.difference = median(differences);
  Deformations corrected = tracked.deformations();
  for (std::size_t f = 0; f < corrected.size(); ++f) {
    const Eigen::MatrixXf here = net.displacements(normalised(inputs_at(f)));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      Twist twist = Twist::Zero();
      twist.head<3>() = here.row(static_cast<Eigen::Index>(n)).cast<double>().transpose();
      DualQuaternion& node = corrected[f].node_to_world[n];
      node = encode::corrected(nodes[n], node, twist);
    }
  }
  return motion::Motion::deforming(tracked.graph(), std::move(corrected));
}

struct Row {
  const char* name;
  bool by_net;
  int rounds; ///< of the refinement through the field
  bench::TruthMeasures measures;
};

void run(const char* folder, int seeds) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  encode::StageTimes times;
  encode::EncodeOptions options = encode::EncodeOptions::of(encode::Preset::kBalanced);
  options.holdout_tracked = 10;
  encode::CaptureRequest request;
  request.open = [&](const ingest::CaptureOptions& how, Progress& to) {
    return ingest::Capture::open(plugins, folder, how, to);
  };
  encode::PreparedCapture prepared = encode::prepare_capture(request, progress);
  encode::FramePass pass = encode::pass_over_frames(*prepared.capture, options, times, progress);
  const encode::TrainingPlan plan = encode::plan_training(pass, options);
  const auto person = std::ranges::find_if(plan.layers, [](const auto& job) { return job.label->layer.has_value(); });
  if (person == plan.layers.end()) throw std::runtime_error("nothing in it deforms");
  encode::TrackedLabel& label = pass.labels.at(person->label->plan.label);
  const std::optional<motion::JointPaths> joints = label.joints();
  if (!joints) throw std::runtime_error("it has no skeleton");
  const motion::Motion tracked = label.layer->motion;
  const int usual_rounds = options.settings.fields.refinement.rounds;
  std::vector<Row> rows{{"none", false, 0, {}},
                        {"nodes", false, usual_rounds, {}},
                        {"net", true, 0, {}},
                        {"net, nodes", true, usual_rounds, {}}};
  Displacements sum;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.settings.fields.trainer.seed = static_cast<std::uint64_t>(seed);
    options.settings.fields.refinement.rounds = usual_rounds;
    std::vector<clip::Layer> others;
    for (const encode::LayerJob& job : plan.layers) {
      if (&job == &*person) continue;
      others.push_back(encode::train_layer(job, pass.pixels, options, times, progress).layer);
      others.back().presence =
          encode::layer_presence(*job.label, others.back().motion, pass.pixels, pass.clip.times.size());
    }
    motion::Motion by_net = tracked;
    for (Row& row : rows) {
      label.layer->motion = row.by_net ? by_net : tracked;
      options.settings.fields.refinement.rounds = row.rounds;
      clip::Layer layer = encode::train_layer(*person, pass.pixels, options, times, progress).layer;
      layer.presence = encode::layer_presence(label, layer.motion, pass.pixels, pass.clip.times.size());
      if (&row == &rows[1]) {
        Displacements found;
        by_net = corrected_by_net(tracked, layer.motion, *joints, pass.pixels, static_cast<unsigned>(seed), found);
        sum.nodes += found.nodes;
        sum.net += found.net;
        sum.difference += found.difference;
      }
      clip::Clip clip = pass.clip;
      clip.layers = others;
      clip.layers.push_back(std::move(layer));
      row.measures.add(folder, std::move(clip), progress);
    }
  }
  std::printf("| corrected by | held out, box dB | other cameras, box dB | inside dB | points mm |\n");
  std::printf("| --- | --- | --- | --- | --- |\n");
  for (const Row& row : rows) row.measures.print(row.name);
  std::printf("\nnodes %.2f mm, net %.2f mm, difference %.2f mm\n", 1000 * sum.nodes / seeds, 1000 * sum.net / seeds,
              1000 * sum.difference / seeds);
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: bench_residual CAPTURE [SEEDS]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::atoi(argv[2]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_residual: %s\n", error.what());
    return 1;
  }
  return 0;
}
