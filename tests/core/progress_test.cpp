#include "core/progress.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace kinora {
namespace {

class Cancelled : public Progress {
  bool cancelled() const override { return true; }
};

TEST(Progress, ByDefaultNeverCancels) { EXPECT_NO_THROW(Progress().check()); }

TEST(Progress, CheckThrowsInterruptedWhenCancelled) {
  try {
    Cancelled().check();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
    EXPECT_EQ(error.exit_code(), 130);
  }
}

} // namespace
} // namespace kinora
