// SPDX-License-Identifier: BSD-3-Clause
#include <archive.h>
#include <archive_entry.h>
#include <itkImageFileReader.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <tuple>

#include "osteomill/io/itk_reading.hpp"

namespace osteomill::io {
namespace {

/// The reader is chosen here by the suffix, so that none depends on what registered itself.
std::pair<itk::ImageIOBase::Pointer, const char*> reader_of(const std::filesystem::path& path) {
  const std::string suffix = path.extension().string();
  if (suffix == ".nrrd" || suffix == ".nhdr") return {itk::NrrdImageIO::New().GetPointer(), "NRRD"};
  if (suffix == ".mha" || suffix == ".mhd")
    return {itk::MetaImageIO::New().GetPointer(), "MetaImage"};
  return {itk::NiftiImageIO::New().GetPointer(), "NIfTI"};
}

/// Bytes of a file after unpacking, which is done where it is packed. -1 when that breaks off.
std::int64_t unpacked_size(const std::filesystem::path& path) {
  const std::unique_ptr<archive, decltype(&archive_read_free)> file(archive_read_new(),
                                                                    archive_read_free);
  archive_read_support_filter_gzip(file.get());
  archive_read_support_format_raw(file.get());
  archive_entry* entry = nullptr;
  if (archive_read_open_filename(file.get(), path.c_str(), 1 << 16) != ARCHIVE_OK ||
      archive_read_next_header(file.get(), &entry) != ARCHIVE_OK)
    return -1;
  std::vector<char> piece(1 << 20);
  std::int64_t size = 0;
  la_ssize_t got = 0;
  while ((got = archive_read_data(file.get(), piece.data(), piece.size())) > 0) size += got;
  return got < 0 ? -1 : size;
}

std::string trimmed(const std::string& text) {
  const char* const blank = " \t\r";
  const std::size_t begin = text.find_first_not_of(blank);
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(blank) + 1 - begin);
}

/// Bytes of voxels that a MetaImage has, packed or not, and how many its header promises.
std::pair<std::int64_t, std::int64_t> meta_image_sizes(const std::filesystem::path& path,
                                                       std::int64_t unpacked) {
  std::ifstream in(path, std::ios::binary);
  std::int64_t promised = unpacked;
  std::string line;
  while (std::getline(in, line)) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) break;
    const std::string key = trimmed(line.substr(0, equals));
    const std::string value = trimmed(line.substr(equals + 1));
    if (key == "CompressedDataSize") promised = std::atoll(value.c_str());
    if (key != "ElementDataFile") continue;
    const bool local = value == "LOCAL";
    std::error_code missing;
    const auto there =
        std::filesystem::file_size(local ? path : path.parent_path() / value, missing);
    if (missing) break;
    return {static_cast<std::int64_t>(there) - (local ? static_cast<std::int64_t>(in.tellg()) : 0),
            promised};
  }
  return {0, promised};
}

/// NIfTI and MetaImage read what is there of a file that was cut short and leave the rest as it
/// may be in memory; so the length is looked at first. NRRD looks itself.
void check_length(const std::filesystem::path& path, const itk::ImageIOBase& io,
                  const std::string& format) {
  if (format == "NRRD") return;
  constexpr std::int64_t kNiftiHeader = 348;
  std::int64_t there = 0;
  auto promised = static_cast<std::int64_t>(io.GetImageSizeInBytes());
  if (format == "NIfTI")
    there = unpacked_size(path) - kNiftiHeader;
  else
    std::tie(there, promised) = meta_image_sizes(path, promised);
  if (there < promised)
    throw InvalidInput({path.string(),
                        fmt::format("{} bytes of voxels", std::max<std::int64_t>(0, there)),
                        fmt::format("is cut short: its header promises {}", promised),
                        "copy or export the file again"});
}

}  // namespace

RawVolume read_image_file(const std::filesystem::path& path) {
  itk::Object::SetGlobalWarningDisplay(false);
  const auto [io, format] = reader_of(path);
  const std::string name = path.string();
  return guarded(path, [&, io = io, format = format] {
    const auto refuse = [&](const std::string& value, const std::string& rule,
                            const std::string& remedy) {
      throw InvalidInput({name, value, rule, remedy});
    };
    if (!io->CanReadFile(name.c_str()))
      refuse("", fmt::format("is no {} file, or its header is broken", format),
             "give the file that its suffix promises");
    io->SetFileName(name);
    io->ReadImageInformation();
    std::string size;
    unsigned axes = 0;
    for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
      size += fmt::format("{}{}", axis == 0 ? "" : " × ", io->GetDimensions(axis));
      if (io->GetDimensions(axis) > 1) axes = axis + 1;
    }
    if (axes != 3)
      refuse(size + " voxels", "is no volume: a CT has three axes",
             "give one volume, not a picture nor a series in time");
    if (io->GetNumberOfComponents() != 1)
      refuse(fmt::format("{} values a voxel", io->GetNumberOfComponents()),
             "is a colour picture or a vector field: a CT has one value a voxel", "give the CT");
    for (unsigned axis = 0; axis < 3; ++axis)
      if (!(io->GetSpacing(axis) > 0.0))
        refuse(fmt::format("spacing {} mm", io->GetSpacing(axis)), "must be > 0 mm",
               "mend the header");
    check_length(path, *io, format);
    const auto reader = itk::ImageFileReader<ItkVolume>::New();
    reader->SetImageIO(io);
    reader->SetFileName(name);
    reader->Update();
    RawVolume raw = from_itk(*reader->GetOutput());
    raw.description = fmt::format("{} {}", format, path.filename().string());
    return raw;
  });
}

}  // namespace osteomill::io
