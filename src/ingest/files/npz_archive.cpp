#include "ingest/files/npz_archive.h"

#include <fmt/format.h>
#include <zip.h>

#include "core/error.h"

namespace kinora::ingest {
namespace {

[[noreturn]] void refuse(const std::string& source, const std::string& what) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", source, what));
}

struct Close {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

} // namespace

void NpzArchive::Discard::operator()(zip* archive) const { zip_discard(archive); }

NpzArchive::NpzArchive(const std::filesystem::path& path) : path_(path.string()) {
  int error = 0;
  archive_.reset(zip_open(path_.c_str(), ZIP_RDONLY, &error));
  if (!archive_) refuse(path_, "it is no .npz file, or a damaged one; copy it again, or write it with numpy.savez");
}

bool NpzArchive::has(const std::string& name) const {
  return zip_name_locate(archive_.get(), (name + ".npy").c_str(), 0) >= 0;
}

NpyArray NpzArchive::read(const std::string& name) const {
  const std::string source = path_ + ", array " + name;
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (!has(name) || zip_stat(archive_.get(), (name + ".npy").c_str(), 0, &stat) != 0) {
    refuse(source, "it is not there; add it with numpy.savez");
  }
  if ((stat.valid & ZIP_STAT_SIZE) == 0 || stat.size > kMaxBytes) {
    refuse(source, fmt::format("it unpacks to more than {} MiB; keep fewer vertices or joints", kMaxBytes >> 20U));
  }
  if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE) {
    refuse(source, "its compression is unknown; write it with numpy.savez or numpy.savez_compressed");
  }
  const std::unique_ptr<zip_file_t, Close> file(zip_fopen_index(archive_.get(), stat.index, 0));
  std::vector<std::byte> bytes(static_cast<std::size_t>(stat.size) + 1); // one more: the end is where checks are made
  std::size_t size = 0;
  while (file && size < bytes.size()) {
    const zip_int64_t got = zip_fread(file.get(), bytes.data() + size, bytes.size() - size);
    if (got < 0) refuse(source, "it is damaged; copy the file again");
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (!file || size != stat.size) refuse(source, "it cannot be unpacked as the archive says; copy the file again");
  bytes.resize(size);
  return parse_npy(bytes, source);
}

} // namespace kinora::ingest
