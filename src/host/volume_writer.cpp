#include "host/volume_writer.h"

#include <iterator>

#include "host/interface_struct.h"
#include "host/option_values.h"

namespace kinora::host {

void write_volume(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                  const Volume& volume, const Facts& facts) {
  WriterHandle writer = open_writer(format, KINORA_WRITES_VOLUMES, "volumes", path, options);
  describe_output(format, writer, facts);
  const KinoraVolumeChannel channels[] = {
      {"density", 1, volume.density.data()},
      {"color", 3, numbers_of(volume.color)},
  };
  auto given = make_struct<KinoraVolume>();
  given.name = volume.name.c_str();
  given.frame = volume.frame;
  given.time = volume.time;
  for (int i = 0; i < 16; ++i) given.voxel_to_world[i] = volume.voxel_to_world(i / 4, i % 4);
  given.voxel_count = volume.voxels.size();
  given.voxels = numbers_of(volume.voxels);
  given.channels = channels;
  given.channel_count = std::size(channels);
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format.writer_volume(writer.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format.name);
  finish_writer(format, writer);
}

Eigen::AlignedBox3d box_of(const Volume& volume) {
  Eigen::AlignedBox3d numbers;
  for (const auto& v : volume.voxels) numbers.extend(Eigen::Vector3d(v[0], v[1], v[2]));
  if (numbers.isEmpty()) return numbers;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5); // to the corners of the outermost voxels
  Eigen::AlignedBox3d box;
  const Eigen::AlignedBox3d whole(numbers.min() - half, numbers.max() + half);
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner = whole.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
    box.extend((volume.voxel_to_world * corner.homogeneous()).head<3>());
  }
  return box;
}

void write_volume_index(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                        const std::vector<VolumeFile>& files, double frames_per_second, const Facts& facts) {
  std::vector<KinoraVolumeFile> given_files;
  for (const VolumeFile& file : files) {
    KinoraVolumeFile given{file.name.c_str(), file.time, {}, {}};
    Eigen::Map<Eigen::Vector3d>(given.low) = file.box.min(); // of an empty box these are the wrong way round
    Eigen::Map<Eigen::Vector3d>(given.high) = file.box.max();
    given_files.push_back(given);
  }
  std::vector<KinoraOptionValue> given_facts;
  for (const auto& [name, value] : facts) given_facts.push_back({name.c_str(), value.c_str()});
  auto sequence = make_struct<KinoraVolumeSequence>();
  sequence.frames_per_second = frames_per_second;
  sequence.file_count = given_files.size();
  sequence.files = given_files.data();
  sequence.fact_count = given_facts.size();
  sequence.facts = given_facts.data();
  const std::vector<KinoraOptionValue> values = option_values(options);
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status =
      format.write_volume_index(path.c_str(), values.data(), values.size(), &sequence, &message);
  if (status != KINORA_OK) throw error_of(status, message, path.string());
}

} // namespace kinora::host
