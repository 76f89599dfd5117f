// SPDX-License-Identifier: BSD-3-Clause
#include <gdcmDirectory.h>
#include <gdcmReader.h>
#include <gdcmScanner.h>
#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkImageSeriesReader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

#include "osteomill/io/itk_reading.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;

const gdcm::Tag kModality(0x0008, 0x0060);
const gdcm::Tag kSeriesDescription(0x0008, 0x103e);
const gdcm::Tag kSeriesUid(0x0020, 0x000e);
const gdcm::Tag kSeriesNumber(0x0020, 0x0011);
const gdcm::Tag kPosition(0x0020, 0x0032);
const gdcm::Tag kOrientation(0x0020, 0x0037);
const gdcm::Tag kRows(0x0028, 0x0010);
const gdcm::Tag kColumns(0x0028, 0x0011);
const gdcm::Tag kPixelSpacing(0x0028, 0x0030);
const gdcm::Tag kSamples(0x0028, 0x0002);
const gdcm::Tag kBits(0x0028, 0x0100);
const gdcm::Tag kPixels(0x7fe0, 0x0010);

struct Slice {
  std::string file;
  std::vector<double> position;     ///< mm in P
  std::vector<double> orientation;  ///< of its rows and its columns
  std::vector<double> spacing;      ///< between rows, between columns, mm
  std::string size;
  std::size_t bytes = 0;  ///< of its pixels, not compressed
  double along = 0.0;     ///< position along the normal, mm
};

struct Series {
  std::string uid;
  std::string number;
  std::string description;
  std::string modality;
  std::string samples;
  std::vector<Slice> slices;

  std::string name() const {
    return fmt::format("{} \"{}\" ({}, {} slices, {})", number, description, modality,
                       slices.size(), uid);
  }
};

std::string trimmed(const char* text) {
  std::string out = text != nullptr ? text : "";
  while (!out.empty() && (out.back() == ' ' || out.back() == '\0')) out.pop_back();
  out.erase(0, out.find_first_not_of(' '));
  return out;
}

/// "a\b\c", as DICOM writes several numbers.
std::vector<double> numbers(const std::string& text) {
  std::vector<double> out;
  const char* at = text.data();
  const char* end = at + text.size();
  while (at < end) {
    while (at < end && (*at == '\\' || *at == ' ' || *at == '+')) ++at;
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc()) break;
    out.push_back(value);
    at = next;
  }
  return out;
}

/// Of whole numbers; 0 when one is none.
std::size_t product(const std::string& rows, const std::string& columns, const std::string& bits) {
  std::size_t out = 1;
  for (const std::string& text : {rows, columns, bits}) {
    const std::vector<double> value = numbers(text);
    out *= value.empty() ? 0 : static_cast<std::size_t>(std::max(0.0, value.front()));
  }
  return out;
}

[[noreturn]] void refuse(const fs::path& path, const std::string& field, const std::string& value,
                         const std::string& rule, const std::string& remedy) {
  throw InvalidInput({path.string() + ": " + field, value, rule, remedy});
}

std::map<std::string, Series> scan(const fs::path& folder) {
  gdcm::Directory directory;
  directory.Load(folder.string(), false);
  gdcm::Scanner scanner;
  for (const gdcm::Tag& tag : {kModality, kSeriesDescription, kSeriesUid, kSeriesNumber, kPosition,
                               kOrientation, kRows, kColumns, kPixelSpacing, kSamples, kBits})
    scanner.AddTag(tag);
  scanner.Scan(directory.GetFilenames());
  std::map<std::string, Series> all;
  for (const std::string& file : directory.GetFilenames()) {
    if (!scanner.IsKey(file.c_str())) continue;
    const auto text = [&](const gdcm::Tag& tag) {
      return trimmed(scanner.GetValue(file.c_str(), tag));
    };
    const std::string uid = text(kSeriesUid);
    if (uid.empty() || text(kRows).empty()) continue;  // no picture: a DICOMDIR, a report
    Series& series = all[uid];
    series.uid = uid;
    series.number = text(kSeriesNumber);
    series.description = text(kSeriesDescription);
    series.modality = text(kModality);
    series.samples = text(kSamples);
    series.slices.push_back({file, numbers(text(kPosition)), numbers(text(kOrientation)),
                             numbers(text(kPixelSpacing)), text(kColumns) + " × " + text(kRows),
                             product(text(kRows), text(kColumns), text(kBits)) / 8});
  }
  return all;
}

Series choose(const fs::path& path, const fs::path& folder, const CtOptions& options) {
  std::map<std::string, Series> all = scan(folder);
  if (all.empty())
    refuse(path, "series", "", "holds no DICOM pictures",
           "name the folder that holds the slices themselves");
  std::vector<Series> fitting;
  std::string names;
  for (const auto& [uid, series] : all) {
    names += "\n  " + series.name();
    const bool of_the_file =
        !fs::is_directory(path) &&
        std::any_of(series.slices.begin(), series.slices.end(), [&](const Slice& slice) {
          return fs::path(slice.file).filename() == path.filename();
        });
    const bool named = options.series == uid || options.series == series.number ||
                       options.series == series.description;
    if (options.series.empty() ? fs::is_directory(path) || of_the_file : named)
      fitting.push_back(series);
  }
  if (fitting.empty())
    refuse(path, "series", options.series, "is not in the folder", "choose one of:" + names);
  if (fitting.size() > 1)
    refuse(path, "series", fmt::format("{} series", fitting.size()), "which one is meant?",
           "choose one by its UID, number or description:" + names);
  return fitting.front();
}

Eigen::Vector3d normal_of(const Slice& slice) {
  const Eigen::Map<const Eigen::Vector3d> row(slice.orientation.data());
  const Eigen::Map<const Eigen::Vector3d> column(slice.orientation.data() + 3);
  return row.cross(column);
}

/// Sorts the slices and refuses what is no regular grid, naming what is wrong with it.
void order(const fs::path& path, Series& series) {
  for (const Slice& slice : series.slices)
    if (slice.position.size() != 3 || slice.orientation.size() != 6 || slice.spacing.size() != 2)
      refuse(path, fs::path(slice.file).filename().string(), "",
             "lacks its position, orientation or pixel spacing",
             "export the series as single slices with Image Position, Image Orientation and Pixel "
             "Spacing");
  const Slice& first = series.slices.front();
  const Eigen::Vector3d normal = normal_of(first);
  for (Slice& slice : series.slices) {
    if (slice.size != first.size || slice.spacing != first.spacing)
      refuse(path, "slices",
             fmt::format("{} and {} pixels of {} and {} mm", first.size, slice.size,
                         first.spacing[0], slice.spacing[0]),
             "are of mixed size or spacing", "separate the series: one reconstruction at a time");
    // 1e-3: 0.06°, below what moves a slice by a tenth of a voxel.
    if ((normal_of(slice) - normal).norm() > 1e-3)
      refuse(path, "slices", fs::path(slice.file).filename().string(),
             "is oriented unlike the others (a scout, or another reconstruction)",
             "remove it from the series");
    slice.along = normal.dot(Eigen::Map<const Eigen::Vector3d>(slice.position.data()));
  }
  std::sort(series.slices.begin(), series.slices.end(),
            [](const Slice& a, const Slice& b) { return a.along < b.along; });
  if (series.slices.size() < 2)
    refuse(path, "slices", "1", "is no volume", "give the folder with all slices of the series");

  std::vector<double> steps;
  for (std::size_t i = 1; i < series.slices.size(); ++i)
    steps.push_back(series.slices[i].along - series.slices[i - 1].along);
  std::vector<double> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double from = series.slices[i].along;
    const std::string where = fmt::format("{:.2f} mm, then {:.2f} mm", from, from + steps[i]);
    if (steps[i] < 1e-3)
      refuse(path, "slices", where, "two slices stand at one position",
             "separate the series: one phase or reconstruction at a time");
    // Positions are rounded to 0.01 or 0.001 mm by scanners; a tenth of a step is neither.
    if (std::abs(steps[i] - usual) <= 0.1 * usual) continue;
    const double missing = steps[i] / usual - 1.0;
    if (std::abs(missing - std::round(missing)) < 0.1 && missing > 0.5)
      refuse(path, "slices", where, fmt::format("{:.0f} missing between them", missing),
             "add the missing slices, or give a part of the series without a gap");
    refuse(path, "slices", where,
           fmt::format("mixed spacing: {:.2f} mm here, {:.2f} mm elsewhere", steps[i], usual),
           "resample the series to one slice spacing");
  }
  const Eigen::Vector3d way =
      Eigen::Map<const Eigen::Vector3d>(series.slices.back().position.data()) -
      Eigen::Map<const Eigen::Vector3d>(series.slices.front().position.data());
  const double tilt =
      std::atan2(way.cross(normal).norm(), way.dot(normal)) * 180.0 / std::numbers::pi;
  // 0.05° shifts the ends of 200 slices of 1 mm by less than 0.2 mm.
  if (tilt > 0.05)
    refuse(path, "gantry tilt", fmt::format("{:.2f}°", tilt),
           "the slices are stacked askew: the grid is not rectangular",
           "export the series with the tilt corrected (deskewed)");
}

/// GDCM reads a slice that ends early without a word, the rest of it as air.
void refuse_cut_short(const fs::path& path, const Series& series) {
  for (const Slice& slice : series.slices) {
    gdcm::Reader reader;
    reader.SetFileName(slice.file.c_str());
    if (!reader.ReadUpToTag(kPixels, {kPixels}))
      refuse(path, fs::path(slice.file).filename().string(), "", "cannot be read as DICOM",
             "copy the series again");
    // What is compressed has no length to be checked by: its decoder finds out.
    if (reader.GetFile().GetHeader().GetDataSetTransferSyntax().IsEncapsulated()) continue;
    const std::size_t begin = reader.GetStreamCurrentPosition();
    const std::size_t size = fs::file_size(slice.file);
    if (size < begin + slice.bytes)
      refuse(path, fs::path(slice.file).filename().string(),
             fmt::format("{} bytes of pixels", size - std::min(size, begin)),
             fmt::format("is cut short: its header says {}", slice.bytes), "copy the series again");
  }
}

}  // namespace

RawVolume read_dicom(const fs::path& path, const CtOptions& options) {
  itk::Object::SetGlobalWarningDisplay(false);
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  const fs::path folder = fs::is_directory(path) ? path : fs::absolute(path).parent_path();
  Series series = choose(path, folder, options);
  if (series.modality != "CT")
    refuse(path, "modality", series.modality, "must be CT: only CT is in Hounsfield units",
           "choose a CT series");
  if (series.samples != "1")
    refuse(path, "samples per pixel", series.samples, "must be 1: this is a colour picture",
           "choose the CT slices, not a screenshot");
  order(path, series);
  refuse_cut_short(path, series);
  return guarded(path, [&] {
    std::vector<std::string> files;
    for (const Slice& slice : series.slices) files.push_back(slice.file);
    const auto reader = itk::ImageSeriesReader<ItkVolume>::New();
    reader->SetImageIO(itk::GDCMImageIO::New());
    reader->SetFileNames(files);
    reader->Update();
    RawVolume raw = from_itk(*reader->GetOutput());
    // The geometry is what the slices say of themselves, all of them and not only the first two.
    const Slice& first = series.slices.front();
    raw.spacing_mm = {
        first.spacing[1], first.spacing[0],
        (series.slices.back().along - first.along) / static_cast<double>(series.slices.size() - 1)};
    raw.origin_mm = Eigen::Map<const Eigen::Vector3d>(first.position.data());
    raw.direction.col(0) = Eigen::Map<const Eigen::Vector3d>(first.orientation.data());
    raw.direction.col(1) = Eigen::Map<const Eigen::Vector3d>(first.orientation.data() + 3);
    raw.direction.col(2) = normal_of(first);
    raw.description = fmt::format("DICOM series {}", series.name());
    return raw;
  });
}

}  // namespace osteomill::io
