#include "ingest/files/npy_array.h"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "npy_bytes.h"

namespace kinora::ingest {
namespace {

using testing::npy;
using testing::npy_with_header;

// The error's sentence; empty if there is none.
std::string refusal(const std::vector<std::byte>& bytes) {
  try {
    parse_npy(bytes, "body.npz, array f");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    return error.what();
  }
  return {};
}

std::string refusal_of_header(const std::string& dictionary) {
  const std::vector<double> two = {1, 2};
  return refusal(npy_with_header(dictionary, std::as_bytes(std::span(two))));
}

TEST(NpyArray, ReadsEveryKindOfNumber) {
  const std::vector<double> expected = {1, 2, 3, 4, 5, 6};
  const auto values = [](const std::vector<std::byte>& bytes) { return parse_npy(bytes, "a").values; };
  EXPECT_EQ(values(npy<float>("<f4", "(2, 3)", {1, 2, 3, 4, 5, 6})), expected);
  EXPECT_EQ(values(npy<double>("<f8", "(2, 3)", expected)), expected);
  EXPECT_EQ(values(npy<std::int32_t>("<i4", "(2, 3)", {1, 2, 3, 4, 5, 6})), expected);
  EXPECT_EQ(values(npy<std::uint32_t>("<u4", "(2, 3)", {1, 2, 3, 4, 5, 6})), expected);
  EXPECT_EQ(values(npy<std::int64_t>("<i8", "(6,)", {1, 2, 3, 4, 5, 6})), expected);
  EXPECT_EQ(values(npy<std::uint64_t>("<u8", "(1, 2, 3)", {1, 2, 3, 4, 5, 6})), expected);
}

TEST(NpyArray, BringsFortranOrderIntoCOrder) {
  const std::vector<double> columns = {1, 4, 2, 5, 3, 6};
  const NpyArray array = parse_npy(
      npy_with_header("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }", std::as_bytes(std::span(columns))),
      "a");
  EXPECT_EQ(array.shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(array.values, (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST(NpyArray, RefusesPickledObjectsAndOtherTypesByName) {
  EXPECT_NE(refusal_of_header("{'descr': '|O', 'fortran_order': False, 'shape': (2,), }").find("pickled objects"),
            std::string::npos);
  for (const char* type : {">f8", "<f2", "|b1", "<U8", "<c16", "", "x"}) {
    EXPECT_NE(refusal_of_header("{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (2,), }")
                  .find("little-endian"),
              std::string::npos)
        << type;
  }
  EXPECT_NE(
      refusal_of_header("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (2,), }").find("it holds records"),
      std::string::npos);
}

TEST(NpyArray, RefusesHeadersThatNumPyDoesNotWrite) {
  ASSERT_EQ(refusal_of_header("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }"), "");
  for (const char* header :
       {"", "{", "{}", "{'descr': '<f8', 'fortran_order': False, }", "{'descr': '<f8', 'shape': (2,), }",
        "{'descr': '<f8', 'descr': '<f8', 'fortran_order': False, 'shape': (2,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), 'more': 1, }",
        "{'descr': '<f8', 'fortran_order': 0, 'shape': (2,), }", "{'descr': '<f8', 'fortran_order': False, 'shape': 2}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-2,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), } x"}) {
    EXPECT_NE(refusal_of_header(header).find("its header is damaged"), std::string::npos) << header;
  }
}

TEST(NpyArray, RefusesShapesThatDoNotMatchTheData) {
  for (const char* shape : {"(3,)", "(1,)", "()", "(2, 2)", "(1000000000, 1000000000, 1000000000)", "(0,)"}) {
    EXPECT_NE(refusal_of_header("{'descr': '<f8', 'fortran_order': False, 'shape': " + std::string(shape) + ", }"), "")
        << shape;
  }
  EXPECT_NE(refusal_of_header("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999,), }").find("absurd"),
            std::string::npos);
  EXPECT_NE(refusal_of_header("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 1, 2), }").find("three"),
            std::string::npos);
}

TEST(NpyArray, RefusesNumbersThatAreNotFinite) {
  EXPECT_NE(refusal(npy<double>("<f8", "(2,)", {1, std::numeric_limits<double>::quiet_NaN()})).find("not finite"),
            std::string::npos);
  EXPECT_NE(refusal(npy<float>("<f4", "(1,)", {std::numeric_limits<float>::infinity()})).find("not finite"),
            std::string::npos);
}

TEST(NpyArray, RefusesEveryTruncation) {
  const std::vector<std::byte> whole = npy<double>("<f8", "(2, 3)", {1, 2, 3, 4, 5, 6});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(refusal({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}), "") << size;
  }
}

} // namespace
} // namespace kinora::ingest
