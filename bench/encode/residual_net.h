// The pose-conditioned residual of Jiang et al., "Instant-NVR", CVPR 2023 (section 4.2, hybrid deformation): a net of
// four layers of 128 that tells of a canonical place (32 numbers) and a pose (72 numbers) how far the place is
// displaced. There it is asked at each sample of a ray; here at the nodes of a deformation graph, so that what it says
// is stored with the motion and a player need not know of it.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Dense>

namespace kinora::bench {

/// Rows are samples.
class ResidualNet {
public:
  static constexpr Eigen::Index kPlace = 32;
  static constexpr Eigen::Index kInputs = kPlace + 72;

  explicit ResidualNet(unsigned seed) : random_(seed) {
    Eigen::Index inputs = kInputs;
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      const Eigen::Index outputs = l + 1 < layers_.size() ? 128 : 3;
      std::normal_distribution<float> normal(0, std::sqrt(2.0F / static_cast<float>(inputs)));
      layers_[l].weights = Eigen::MatrixXf::NullaryExpr(inputs + 1, outputs, [&] { return normal(random_); });
      layers_[l].weights.bottomRows(1).setZero();
      if (outputs == 3) layers_[l].weights.setZero(); // no residual at first
      layers_[l].mean = layers_[l].square = Eigen::MatrixXf::Zero(inputs + 1, outputs);
      inputs = outputs;
    }
  }

  /// Sines and cosines of 16 planes across a place (metres), of wavelengths from 2 m to 0.2 m.
  static Eigen::RowVectorXf encoded(const Eigen::Vector3d& place) {
    constexpr double kTwoPi = 6.283185307179586;
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    Eigen::RowVectorXf code(kPlace);
    for (int k = 0; k < kPlace / 2; ++k) {
      const Eigen::Vector3d direction = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
      const double phase = kTwoPi * direction.dot(place) / (2.0 * std::pow(0.1, k / 15.0));
      code[2 * k] = static_cast<float>(std::sin(phase));
      code[2 * k + 1] = static_cast<float>(std::cos(phase));
    }
    return code;
  }

  Eigen::MatrixXf displacements(const Eigen::MatrixXf& inputs) {
    for (std::size_t l = 0; l < layers_.size(); ++l) forward(l, l == 0 ? inputs : layers_[l - 1].output);
    return layers_.back().output;
  }

  /// Least absolute differences (beyond a tenth of `scale`), by Adam, with a rate that falls to nothing.
  void train(const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& targets, float scale, int steps) {
    constexpr Eigen::Index kBatch = 1024;
    std::uniform_int_distribution<Eigen::Index> any(0, inputs.rows() - 1);
    Eigen::MatrixXf batch(kBatch, kInputs), wanted(kBatch, 3);
    for (int step = 1; step <= steps; ++step) {
      for (Eigen::Index i = 0; i < kBatch; ++i) {
        const Eigen::Index k = any(random_);
        batch.row(i) = inputs.row(k);
        wanted.row(i) = targets.row(k);
      }
      const Eigen::MatrixXf off = displacements(batch) - wanted;
      const float bend = scale / 10;
      const Eigen::MatrixXf slope = (off.array() / (off.array().square() + bend * bend).sqrt()).matrix() / kBatch;
      backward(batch, slope, step, 2e-3F * (1 - static_cast<float>(step) / static_cast<float>(steps + 1)));
    }
  }

private:
  struct Layer {
    Eigen::MatrixXf weights, mean, square; ///< the last row: biases
    Eigen::MatrixXf output;
  };

  void forward(std::size_t l, const Eigen::MatrixXf& inputs) {
    Layer& layer = layers_[l];
    layer.output.noalias() = inputs * layer.weights.topRows(inputs.cols());
    layer.output.rowwise() += layer.weights.row(inputs.cols());
    if (l + 1 < layers_.size()) layer.output = layer.output.cwiseMax(0);
  }

  void backward(const Eigen::MatrixXf& inputs, Eigen::MatrixXf slope, int step, float rate) {
    for (std::size_t l = layers_.size(); l-- > 0;) {
      Layer& layer = layers_[l];
      const Eigen::MatrixXf& before = l == 0 ? inputs : layers_[l - 1].output;
      Eigen::MatrixXf gradient(layer.weights.rows(), layer.weights.cols());
      gradient.topRows(before.cols()).noalias() = before.transpose() * slope;
      gradient.bottomRows(1) = slope.colwise().sum();
      if (l > 0) {
        const Eigen::MatrixXf next = slope * layer.weights.topRows(before.cols()).transpose();
        slope = (before.array() > 0).select(next, 0);
      }
      layer.mean = 0.9F * layer.mean + 0.1F * gradient;
      layer.square = 0.99F * layer.square + 0.01F * gradient.cwiseAbs2();
      const float unbiased =
          std::sqrt(1 - std::pow(0.99F, static_cast<float>(step))) / (1 - std::pow(0.9F, static_cast<float>(step)));
      layer.weights.array() -= rate * unbiased * layer.mean.array() / (layer.square.array().sqrt() + 1e-8F);
    }
  }

  std::mt19937 random_;
  std::array<Layer, 5> layers_; ///< four hidden ones and the output
};

} // namespace kinora::bench
