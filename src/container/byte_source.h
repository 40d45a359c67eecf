// Bytes that a reader reads: a file, or memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace kinora::container {

/// Random access to bytes. Not thread-safe.
class ByteSource {
public:
  virtual ~ByteSource() = default;
  virtual const std::string& name() const = 0; ///< for errors
  virtual std::uint64_t size() const = 0;      ///< as of opening, or of the last refresh()
  /// Fills `out` from `offset`; offset + out.size() ≤ size(). Throws Error(kCorruptInput) if the system cannot read.
  virtual void read(std::uint64_t offset, std::span<std::byte> out) = 0;
  /// Whether refresh() may find more.
  virtual bool may_grow() const { return false; }
  /// Takes note of what was written since. Throws Error(kCorruptInput) if the file has become shorter.
  virtual void refresh() {}
};

/// A file, through a small buffer, so that element headers cost no system call each.
class FileSource final : public ByteSource {
public:
  /// Throws Error(kNotRecognised) if there is no such file, or if it is a folder or device.
  explicit FileSource(const std::filesystem::path& path);
  ~FileSource() override;
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> out) override;
  bool may_grow() const override { return true; }
  void refresh() override;

private:
  void read_through(std::uint64_t offset, std::span<std::byte> out);

  std::string name_;
  std::FILE* file_ = nullptr;
  std::uint64_t size_ = 0;
  std::vector<std::byte> buffer_;
  std::uint64_t buffer_offset_ = 0;
};

/// Bytes that somebody else owns and keeps alive.
class MemorySource final : public ByteSource {
public:
  MemorySource(std::span<const std::byte> bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> out) override;

private:
  std::span<const std::byte> bytes_;
  std::string name_;
};

} // namespace kinora::container
