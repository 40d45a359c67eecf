// What is done to a field's occupancy must not depend on how many threads do it.
#pragma once

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/model/field.h"

namespace kinora::fields::testing {

/// `change`d copies of the field have the same cells for any number of threads.
template <class Change> void expect_same_cells_for_any_number_of_threads(const Field& field, const Change& change) {
  std::vector<std::vector<std::uint64_t>> words;
  for (const std::size_t threads : {1, 2, 7}) {
    set_thread_count(threads);
    Field changed = field;
    change(changed);
    words.push_back(changed.occupancy.words());
  }
  set_thread_count(0);
  EXPECT_EQ(words[0], words[1]);
  EXPECT_EQ(words[0], words[2]);
}

} // namespace kinora::fields::testing
