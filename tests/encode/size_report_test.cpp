// The report's account of a field's size: what larger tables were tried, what they bought and what they cost.
#include <gtest/gtest.h>

#include "encode/size_report.h"

namespace kinora::encode {
namespace {

TEST(SizeReport, TellsOfEachTrialWhatItBoughtAndWhatItCost) {
  fields::TableGrowthTrial trial;
  trial.begin = 4000;
  trial.discarded_rays = 500;
  trial.table_fill = 0.751;
  trial.log2_table_size = 13;
  trial.bytes = 1000;
  trial.grown_bytes = 1900;
  trial.error = 0.003; // 30 dB: a mean of three channels
  trial.grown_error = 0.0003;
  trial.kept = true;
  fields::TrainingReport training;
  training.bytes = 1900;
  training.table_growth = {trial, {}};
  const nlohmann::json size = size_json({}, {}, fields::Field(fields::FieldConfig{}), training);
  EXPECT_EQ(size.at("training_bytes"), 1900);
  ASSERT_EQ(size.at("growth").size(), 2U);
  EXPECT_EQ(size.at("growth")[0], nlohmann::json::parse(R"({"after_rays": 4000, "price_rays": 500, "table_fill": 0.75,
    "log2_table_size": [13, 14], "bytes": [1000, 1900], "psnr_held_apart": [30.0, 40.0], "kept": true})"));
  EXPECT_EQ(size.at("growth")[1].at("kept"), false);
}

} // namespace
} // namespace kinora::encode
