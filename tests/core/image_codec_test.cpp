#include "core/image_codec.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/sample_images.h"

namespace kinora {
namespace {

using test::jpeg_of;
using test::sample_color;
using test::sample_depth;

/// The sentence of the error that `call` throws; fails the test unless it is kCorruptInput and names the source.
template <class Call> std::string corrupt_sentence(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_TRUE(std::string(error.what()).starts_with("a.img: ")) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

template <class T> bool equal(const Image<T>& a, const Image<T>& b) {
  return a.width() == b.width() && a.height() == b.height() && a.channels() == b.channels() &&
         std::equal(a.values().begin(), a.values().end(), b.values().begin());
}

std::uint32_t crc_of(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::byte byte : bytes) {
    crc ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/// Changes the header of a PNG and puts its checksum right again.
Bytes with_header(Bytes png, int width, int height, int bits) {
  const auto put = [&png](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) png[at + i] = static_cast<std::byte>(value >> (24 - 8 * i));
  };
  put(16, static_cast<std::uint32_t>(width));
  put(20, static_cast<std::uint32_t>(height));
  png[24] = static_cast<std::byte>(bits);
  put(29, crc_of(std::span(png).subspan(12, 17)));
  return png;
}

TEST(ImageCodec, PngOfColorComesBackUnchanged) {
  for (const int width : {1, 7, 64}) {
    const ColorImage image = sample_color(width, 33);
    EXPECT_TRUE(equal(decode_color(encode_png(image), "a.img"), image));
  }
}

TEST(ImageCodec, GreyIsRepeatedAndAlphaIsDropped) {
  const ColorImage grey = sample_color(9, 5, 1);
  const ColorImage from_grey = decode_color(encode_png(grey), "a.img");
  ASSERT_EQ(from_grey.channels(), 3);
  const ColorImage rgba = sample_color(9, 5, 4);
  const ColorImage from_rgba = decode_color(encode_png(rgba), "a.img");
  ASSERT_EQ(from_rgba.channels(), 3);
  for (int v = 0; v < 5; ++v)
    for (int u = 0; u < 9; ++u)
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(from_grey.at(u, v, c), grey.at(u, v));
        EXPECT_EQ(from_rgba.at(u, v, c), rgba.at(u, v, c));
      }
}

TEST(ImageCodec, PngOfDepthComesBackUnchanged) {
  DepthImage16 depth = sample_depth(31, 17);
  depth.at(3, 4) = 0xFF00;
  depth.at(4, 4) = 0x00FF;
  EXPECT_TRUE(equal(decode_depth16(encode_png16(depth), "a.img"), depth));
}

TEST(ImageCodec, SameImageGivesSameBytes) {
  EXPECT_EQ(encode_png(sample_color(40, 30)), encode_png(sample_color(40, 30)));
}

TEST(ImageCodec, TextsStandInThePngAsTheyAre) {
  const PngTexts texts = {{"source", "Größe 1.mkv"}, {"lost", "depth; \n the times"}};
  const ColorImage image = sample_color(40, 30);
  const Bytes said = encode_png(image, texts);
  const std::string bytes(reinterpret_cast<const char*>(said.data()), said.size());
  for (const auto& [keyword, text] : texts) {
    // Keyword, its end, no compression (two bytes), no language and no translation of the keyword, text.
    std::string chunk = "iTXt" + keyword;
    chunk.append(5, '\0').append(text);
    const std::size_t found = bytes.find(chunk);
    ASSERT_NE(found, std::string::npos) << keyword;
    EXPECT_LT(found, bytes.find("IDAT")) << "a reader has them before it has the pixels";
  }
  EXPECT_TRUE(equal(decode_color(said, "a.img"), image));
  EXPECT_EQ(said, encode_png(image, texts));
  const Bytes depth = encode_png16(sample_depth(8, 8), texts);
  EXPECT_GT(depth.size(), encode_png16(sample_depth(8, 8)).size());
  EXPECT_TRUE(equal(decode_depth16(depth, "a.img"), sample_depth(8, 8)));
}

TEST(ImageCodec, JpegIsReadWithinItsQuality) {
  ColorImage image(32, 24, 3);
  for (int v = 0; v < 24; ++v)
    for (int u = 0; u < 32; ++u)
      for (int c = 0; c < 3; ++c) image.at(u, v, c) = static_cast<std::uint8_t>(40 + 3 * u + 2 * v + 10 * c);
  const ColorImage read = decode_color(jpeg_of(image), "a.img");
  ASSERT_TRUE(read.same_size(image));
  for (std::size_t i = 0; i < image.values().size(); ++i) ASSERT_NEAR(read.data()[i], image.data()[i], 6);
}

TEST(ImageCodec, GreyJpegBecomesThreeEqualChannels) {
  const ColorImage read = decode_color(jpeg_of(sample_color(16, 16, 1)), "a.img");
  ASSERT_EQ(read.channels(), 3);
  EXPECT_EQ(read.at(5, 5, 0), read.at(5, 5, 1));
  EXPECT_EQ(read.at(5, 5, 0), read.at(5, 5, 2));
}

TEST(ImageCodec, EveryTruncationIsAnError) {
  const Bytes color = encode_png(sample_color(20, 20));
  const Bytes depth = encode_png16(sample_depth(20, 20));
  const Bytes jpeg = jpeg_of(sample_color(20, 20));
  for (std::size_t size = 0; size < color.size(); size += 3)
    corrupt_sentence([&] { decode_color(std::span(color).first(size), "a.img"); });
  for (std::size_t size = 0; size < depth.size(); ++size)
    corrupt_sentence([&] { decode_depth16(std::span(depth).first(size), "a.img"); });
  for (std::size_t size = 0; size + 2 < jpeg.size(); ++size)
    corrupt_sentence([&] { decode_color(std::span(jpeg).first(size), "a.img"); });
}

TEST(ImageCodec, DamagedPixelsAreAnError) {
  Bytes png = encode_png(sample_color(20, 20));
  png[png.size() / 2] ^= std::byte{0x10};
  corrupt_sentence([&] { decode_color(png, "a.img"); });
}

TEST(ImageCodec, DepthOfAnotherKindIsRefusedByName) {
  EXPECT_NE(corrupt_sentence([] { decode_depth16(encode_png(sample_color(8, 8, 1)), "a.img"); }).find("16-bit"),
            std::string::npos);
  EXPECT_NE(corrupt_sentence([] { decode_depth16(encode_png(sample_color(8, 8, 3)), "a.img"); }).find("colour"),
            std::string::npos);
  corrupt_sentence([] { decode_depth16(jpeg_of(sample_color(8, 8)), "a.img"); });
  EXPECT_NE(corrupt_sentence([] { decode_color(encode_png16(sample_depth(8, 8)), "a.img"); }).find("depth image"),
            std::string::npos);
}

TEST(ImageCodec, EmptyFilesAndOtherKindsAreRefused) {
  EXPECT_NE(corrupt_sentence([] { decode_color({}, "a.img"); }).find("empty"), std::string::npos);
  EXPECT_NE(corrupt_sentence([] { decode_depth16({}, "a.img"); }).find("empty"), std::string::npos);
  EXPECT_NE(corrupt_sentence([] { decode_labels({}, "a.img"); }).find("empty"), std::string::npos);
  const Bytes text(100, std::byte{'x'});
  corrupt_sentence([&] { decode_color(text, "a.img"); });
  corrupt_sentence([&] { decode_labels(text, "a.img"); });
}

TEST(ImageCodec, HugeHeadersAreRefusedBeforeMemoryIsTaken) {
  const Bytes png = encode_png(sample_color(8, 8));
  corrupt_sentence([&] { decode_color(with_header(png, 16000, 16000, 8), "a.img"); });
  corrupt_sentence([&] { decode_color(with_header(png, 20000, 8, 8), "a.img"); });
  corrupt_sentence([&] { decode_color(with_header(png, 0, 8, 8), "a.img"); });
}

TEST(ImageCodec, BitsAreExpandedOnlyIfTheFileIsLargeEnoughForWhatTheyBecome) {
  Bytes png = with_header(encode_png(sample_color(8, 8, 1)), 16384, 16384, 1); // 32 MiB of bits, 768 MiB of colours
  png.resize(147'000);
  EXPECT_NE(corrupt_sentence([&] { decode_color(png, "a.img"); }).find("far too short"), std::string::npos);
  EXPECT_NE(corrupt_sentence([&] { decode_labels(png, "a.img"); }).find("far too short"), std::string::npos);
}

/// Changes the size in a JPEG's frame header, and fills the file up to `bytes`.
Bytes with_jpeg_size(Bytes jpeg, int width, int height, std::size_t bytes) {
  for (std::size_t i = 2; i + 9 < jpeg.size(); ++i) {
    if (jpeg[i] != std::byte{0xFF} || (jpeg[i + 1] != std::byte{0xC0} && jpeg[i + 1] != std::byte{0xC2})) continue;
    const int values[] = {height, width};
    for (std::size_t k = 0; k < 2; ++k) {
      jpeg[i + 5 + 2 * k] = static_cast<std::byte>(values[k] >> 8);
      jpeg[i + 6 + 2 * k] = static_cast<std::byte>(values[k] & 0xFF);
    }
    break;
  }
  jpeg.resize(bytes);
  return jpeg;
}

TEST(ImageCodec, JpegsAreUnpackedOnlyIfTheFileIsLargeEnough) {
  const Bytes large = with_jpeg_size(jpeg_of(sample_color(16, 16)), 8192, 8192, 140'000); // 192 MiB of pixels
  EXPECT_NE(corrupt_sentence([&] { decode_color(large, "a.img"); }).find("far too short"), std::string::npos);
}

TEST(ImageCodec, CoefficientsOfProgressiveJpegsAreBounded) {
  // 57 MiB of pixels would do, but not 114 MiB of coefficients.
  const Bytes large = with_jpeg_size(jpeg_of(sample_color(16, 16), true), 5000, 4000, 42'000);
  EXPECT_NE(corrupt_sentence([&] { decode_color(large, "a.img"); }).find("so large a progressive"), std::string::npos);
}

TEST(ImageCodec, LabelsAreTakenAsTheyAre) {
  ColorImage mask(6, 1, 1);
  for (int u = 0; u < 6; ++u) mask.at(u, 0) = static_cast<std::uint8_t>(u);
  const LabelImage labels = decode_labels(encode_png(mask), "a.img");
  for (int u = 0; u < 6; ++u) EXPECT_EQ(labels.at(u, 0), u);
}

TEST(ImageCodec, ASingleSmallLabelKeepsItsNumber) {
  ColorImage mask(4, 1, 1);
  mask.at(2, 0) = 2;
  EXPECT_EQ(decode_labels(encode_png(mask), "a.img").at(2, 0), 2);
}

TEST(ImageCodec, BinaryMaskOfEightBitsIsLabelOne) {
  ColorImage mask(4, 1, 1);
  mask.at(1, 0) = 255;
  const LabelImage labels = decode_labels(encode_png(mask), "a.img");
  EXPECT_EQ(labels.at(0, 0), 0);
  EXPECT_EQ(labels.at(1, 0), 1);
}

TEST(ImageCodec, TwoLargeValuesAreNoBinaryMask) {
  ColorImage mask(4, 1, 1);
  mask.at(1, 0) = 255;
  mask.at(2, 0) = 200;
  const LabelImage labels = decode_labels(encode_png(mask), "a.img");
  EXPECT_EQ(labels.at(1, 0), 255);
  EXPECT_EQ(labels.at(2, 0), 200);
}

TEST(ImageCodec, BinaryMaskOfSixteenBitsIsLabelOne) {
  DepthImage16 mask(4, 1);
  mask.at(1, 0) = 65535;
  mask.at(2, 0) = 0x0100;
  const LabelImage labels = decode_labels(encode_png16(mask), "a.img");
  EXPECT_EQ(labels.at(0, 0), 0);
  EXPECT_EQ(labels.at(1, 0), 1);
  EXPECT_EQ(labels.at(2, 0), 1);
}

TEST(ImageCodec, BinaryMaskOfOneBitIsLabelOne) {
  // 8x1 pixels, 1 bit: the filter byte and one byte of pixels, 0b01000001, in a stored deflate block.
  const unsigned char bytes[] = {0x89, 'P',  'N',  'G',  0x0D, 0x0A, 0x1A, 0x0A, 0,    0,    0,    13,   'I',  'H',
                                 'D',  'R',  0,    0,    0,    8,    0,    0,    0,    1,    1,    0,    0,    0,
                                 0,    0,    0,    0,    0,    0,    0,    0,    13,   'I',  'D',  'A',  'T',  0x78,
                                 0x01, 0x01, 0x02, 0x00, 0xFD, 0xFF, 0x00, 0x41, 0x00, 0x43, 0x00, 0x42, 0,    0,
                                 0,    0,    0,    0,    0,    0,    'I',  'E',  'N',  'D',  0xAE, 0x42, 0x60, 0x82};
  const auto view = std::as_bytes(std::span(bytes));
  Bytes png = with_header(Bytes(view.begin(), view.end()), 8, 1, 1);
  const std::uint32_t crc = crc_of(std::span(png).subspan(37, 17));
  for (std::size_t i = 0; i < 4; ++i) png[54 + i] = static_cast<std::byte>(crc >> (24 - 8 * i));
  const LabelImage labels = decode_labels(png, "a.img");
  const int expected[] = {0, 1, 0, 0, 0, 0, 0, 1};
  for (int u = 0; u < 8; ++u) EXPECT_EQ(labels.at(u, 0), expected[u]);
}

TEST(ImageCodec, ColouredMasksAreRefused) {
  EXPECT_NE(corrupt_sentence([] { decode_labels(encode_png(sample_color(8, 8, 3)), "a.img"); }).find("mask"),
            std::string::npos);
}

} // namespace
} // namespace kinora
