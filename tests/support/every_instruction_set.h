// Tests that run on every instruction set that the machine has.
#pragma once

#include <cstdint>
#include <string>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace kinora {

class OnEveryInstructionSet : public ::testing::TestWithParam<std::int64_t> {
protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

inline auto every_instruction_set() { return ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()); }
inline std::string name_of_set(const ::testing::TestParamInfo<std::int64_t>& set) { return hwy::TargetName(set.param); }

} // namespace kinora
