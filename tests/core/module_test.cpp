#include "core/module.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace kinora {
namespace {

TEST(Module, OneThatIsNotThereIsAnErrorThatSaysWhereAndWhatFor) {
  try {
    module_symbol("nothing", "kinora_functions", "to do nothing");
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMissingComponent);
    const std::string sentence = error.what();
    EXPECT_NE(sentence.find("lib/kinora/nothing.so is not there"), std::string::npos) << sentence;
    EXPECT_NE(sentence.find("to do nothing"), std::string::npos) << sentence;
  }
}

} // namespace
} // namespace kinora
