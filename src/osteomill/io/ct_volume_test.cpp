// SPDX-License-Identifier: BSD-3-Clause
#include "osteomill/io/ct_volume.hpp"

#include <gdcmTrace.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImageFileWriter.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>

#include "osteomill/base/error.hpp"
#include "osteomill/base/units.hpp"
#include "osteomill/io/itk_reading.hpp"
#include "osteomill/io/scratch_folder.hpp"
#include "osteomill/io/text_file.hpp"

namespace osteomill::io {
namespace {

namespace fs = std::filesystem;
using geometry::Vector3;
using units::mm;

const char* const kCranium = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";

using Image = itk::Image<short, 3>;

/// A small head: air, soft tissue, a shell of bone; no two axes alike.
Image::Pointer head(const Eigen::Matrix3d& direction) {
  const auto image = Image::New();
  Image::RegionType region;
  region.SetSize({7, 6, 5});
  image->SetRegions(region);
  const double spacing[] = {0.5, 0.75, 1.25};
  const double origin[] = {-12.5, 30.0, 7.25};
  image->SetSpacing(spacing);
  image->SetOrigin(origin);
  Image::DirectionType axes;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j) axes[i][j] = direction(i, j);
  image->SetDirection(axes);
  image->Allocate();
  for (short z = 0; z < 5; ++z)
    for (short y = 0; y < 6; ++y)
      for (short x = 0; x < 7; ++x)
        image->SetPixel({x, y, z}, static_cast<short>(-1000 + 400 * x + 17 * y + 3 * z));
  return image;
}

Eigen::Matrix3d turned() {
  return (Eigen::AngleAxisd(0.3, Vector3::UnitZ()) * Eigen::AngleAxisd(-0.2, Vector3::UnitX()))
      .toRotationMatrix();
}

template <class Io, class Picture>
fs::path write(const fs::path& path, const Picture& image, bool packed = false) {
  const auto writer = itk::ImageFileWriter<typename Picture::ObjectType>::New();
  writer->SetImageIO(Io::New());
  writer->SetFileName(path.string());
  writer->SetInput(image);
  writer->SetUseCompression(packed);
  writer->Update();
  return path;
}

/// What a DICOM writer varies in these tests.
struct Dicom {
  std::string uid = "1.2.826.0.1.3680043.2.1125.1";
  std::string description = "Head bone";
  std::string modality = "CT";
  std::string prefix = "a";
  std::function<double(int)> z_mm = [](int z) { return 1.25 * z; };  ///< along the normal
  double tilt_mm = 0.0;  ///< each slice moved along its columns
  double pixel_mm = 0.5;
  int slices = 5;
};

fs::path write_dicom(const fs::path& folder, const Dicom& how,
                     const Eigen::Matrix3d& direction = Eigen::Matrix3d::Identity()) {
  gdcm::Trace::WarningOff();
  fs::create_directories(folder);
  const Image::Pointer image = head(direction);
  for (int z = 0; z < how.slices; ++z) {
    using Slice = itk::Image<short, 3>;
    const auto slice = Slice::New();
    Slice::RegionType region;
    region.SetSize({7, 6, 1});
    slice->SetRegions(region);
    slice->SetDirection(image->GetDirection());
    const double spacing[] = {how.pixel_mm, 0.75, 1.25};
    slice->SetSpacing(spacing);
    slice->Allocate();
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 7; ++x)
        slice->SetPixel({x, y, 0}, image->GetPixel({x, y, std::min(z, 4)}));
    const Vector3 p = Vector3(-12.5, 30.0, 7.25) + direction.col(2) * how.z_mm(z) +
                      direction.col(1) * how.tilt_mm * z;
    const double origin[] = {p.x(), p.y(), p.z()};
    slice->SetOrigin(origin);
    const auto io = itk::GDCMImageIO::New();
    io->KeepOriginalUIDOn();
    auto& tags = slice->GetMetaDataDictionary();
    const auto put = [&](const char* tag, const std::string& value) {
      itk::EncapsulateMetaData<std::string>(tags, tag, value);
    };
    put("0008|0060", how.modality);
    put("0008|103e", how.description);
    put("0020|000d", "1.2.826.0.1.3680043.2.1125.7");
    put("0020|000e", how.uid);
    put("0020|0052", "1.2.826.0.1.3680043.2.1125.8");
    put("0008|0018", how.uid + "." + std::to_string(z + 1));
    put("0020|0011", how.uid.substr(how.uid.size() - 1));
    put("0020|0013", std::to_string(z + 1));
    put("0028|1052", "-1024");
    put("0028|1053", "1");
    const auto writer = itk::ImageFileWriter<Slice>::New();
    writer->SetImageIO(io);
    // Names against the order of the slices: it is the positions that count.
    writer->SetFileName((folder / fmt::format("{}{}.dcm", how.prefix, how.slices - z)).string());
    writer->SetInput(slice);
    writer->Update();
  }
  return folder;
}

/// Every voxel stands at the place of the patient where it was written, with its value.
void expect_equal_to_head(const CtVolume& ct, const Eigen::Matrix3d& direction) {
  const Image::Pointer image = head(direction);
  const geometry::GridShape& shape = ct.hounsfield.shape();
  ASSERT_EQ(shape.count(), 7u * 6u * 5u);
  EXPECT_GT(ct.X_PG.linear().determinant(), 0.0);
  for (int z = 0; z < shape.size[2]; ++z)
    for (int y = 0; y < shape.size[1]; ++y)
      for (int x = 0; x < shape.size[0]; ++x) {
        const Vector3 p_P = ct.X_PG * shape.centre(x, y, z) / mm;
        Image::PointType point;
        for (unsigned i = 0; i < 3; ++i) point[i] = p_P[i];
        const auto index = image->TransformPhysicalPointToContinuousIndex<double>(point);
        Image::IndexType nearest;
        for (unsigned i = 0; i < 3; ++i) {
          nearest[i] = std::lround(index[i]);
          // Headers in single precision: 30 mm * 2^-24 over voxels of 0.5 mm, some 1e-5 voxels.
          EXPECT_NEAR(index[i], static_cast<double>(nearest[i]), 1e-4);
        }
        EXPECT_EQ(ct.hounsfield.at(x, y, z), image->GetPixel(nearest));
      }
}

TEST(CtVolume, ComesBackFromEachFormatAsItWasWritten) {
  for (const Eigen::Matrix3d& direction :
       {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turned()}) {
    const Image::Pointer image = head(direction);
    for (const fs::path& path : {write<itk::NiftiImageIO>(scratch("head.nii"), image),
                                 write<itk::NiftiImageIO>(scratch("head.nii.gz"), image),
                                 write<itk::NrrdImageIO>(scratch("head.nrrd"), image),
                                 write<itk::MetaImageIO>(scratch("head.mha"), image),
                                 write<itk::MetaImageIO>(scratch("head.mhd"), image),
                                 write<itk::NrrdImageIO>(scratch("packed.nrrd"), image, true),
                                 write<itk::MetaImageIO>(scratch("packed.mha"), image, true),
                                 write_dicom(scratch("dicom"), {}, direction)}) {
      SCOPED_TRACE(path.string());
      const CtVolume ct = read_ct(path);
      expect_equal_to_head(ct, direction);
      EXPECT_NEAR(ct.hounsfield.shape().spacing.prod() / mm / mm / mm, 0.5 * 0.75 * 1.25, 1e-6);
    }
  }
}

TEST(CtVolume, ALeftHandedGridIsTurnedNotMirrored) {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Matrix3d direction = turned();
    direction.col(axis) *= -1.0;
    const CtVolume ct = read_ct(write<itk::NrrdImageIO>(scratch("left.nrrd"), head(direction)));
    expect_equal_to_head(ct, direction);
  }
}

TEST(CtVolume, ReadsTheRealHead) {
  const CtVolume ct = read_ct(kCranium);
  const geometry::GridShape& shape = ct.hounsfield.shape();
  EXPECT_EQ(shape.size, (std::array<int, 3>{256, 256, 108}));
  EXPECT_NEAR(shape.spacing.x() / mm, 0.9570312, 1e-9);
  EXPECT_NEAR(shape.spacing.y() / mm, 0.9570312, 1e-9);
  EXPECT_NEAR(shape.spacing.z() / mm, 1.5, 1e-12);
  const auto [low, high] =
      std::minmax_element(ct.hounsfield.values().begin(), ct.hounsfield.values().end());
  // What the project says of its own values: -1024 … 3033.
  EXPECT_EQ(*low, -1024);
  EXPECT_LE(*high, 3033);
  EXPECT_GT(*high, 2500);
  EXPECT_THAT(ct.description, testing::HasSubstr("ProMED CT 0051"));

  // Places read off the slices, in the frame of the surfaces that InVesalius saved beside them.
  const auto at = [&](double x, double y, double z) {
    return geometry::sample(ct.hounsfield, ct.X_PG.inverse() * Vector3(x * mm, y * mm, z * mm));
  };
  EXPECT_GT(at(160.6, -74.4, 139.4), 800.0);          // outer table
  EXPECT_NEAR(at(120.0, -120.0, 100.0), 30.0, 40.0);  // brain
  EXPECT_LT(at(240.0, -5.0, 150.0), -900.0);          // air beside the head
  EXPECT_LT(at(115.0, -194.0, 90.0), -900.0);         // frontal sinus: the face looks to -y
}

TEST(CtVolume, ResamplesALinearFieldExactlyInATurnedFrame) {
  const CtVolume ct = read_ct(write<itk::NrrdImageIO>(scratch("linear.nrrd"), head(turned())));
  geometry::GridShape region;
  region.size = {9, 7, 5};
  region.spacing = Vector3(0.1, 0.1, 0.1) * mm;
  geometry::Pose X_PW = ct.X_PG;
  X_PW.translate(Vector3(1.0, 1.0, 2.0) * mm);
  X_PW.rotate(Eigen::AngleAxisd(0.4, Vector3(1.0, 2.0, 3.0).normalized()));
  const geometry::VoxelGrid<float> out = resample(ct, region, X_PW);
  for (int z = 0; z < 5; ++z)
    for (int y = 0; y < 7; ++y)
      for (int x = 0; x < 9; ++x) {
        const Vector3 voxel = (ct.X_PG.inverse() * X_PW * region.centre(x, y, z))
                                  .cwiseQuotient(ct.hounsfield.shape().spacing);
        // 3000 HU in single precision: 2^-13; the header's rotation adds 1e-7 of 400 HU a voxel.
        EXPECT_NEAR(out.at(x, y, z),
                    -1000.0 + 400.0 * voxel.x() + 17.0 * voxel.y() + 3.0 * voxel.z(), 1e-3);
      }
}

TEST(CtVolume, ResamplesTheSameOnAnyNumberOfThreads) {
  const CtVolume ct = read_ct(write<itk::NrrdImageIO>(scratch("threads.nrrd"), head(turned())));
  geometry::GridShape region;
  region.size = {20, 20, 20};
  region.spacing = Vector3::Constant(0.1 * mm);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = resample(ct, region, ct.X_PG).values();
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 4);
  EXPECT_EQ(alone, resample(ct, region, ct.X_PG).values());
}

TEST(CtVolume, RefusesARegionThatReachesOutOfTheScan) {
  const CtVolume ct = read_ct(write<itk::NrrdImageIO>(scratch("out.nrrd"), head(turned())));
  geometry::GridShape region;
  region.size = {50, 2, 2};
  region.spacing = Vector3::Constant(0.1 * mm);
  EXPECT_THROW(resample(ct, region, ct.X_PG), InvalidInput);
}

void expect_refused(const std::string& what, const fs::path& path, const std::string& message,
                    const CtOptions& options = {}) {
  try {
    read_ct(path, options);
    ADD_FAILURE() << what << ": was read";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(path.filename().string())) << what;
    EXPECT_THAT(error.what(), testing::HasSubstr(message)) << what;
  }
}

TEST(CtVolume, RefusesFilesThatAreCutShortOrNoCt) {
  const auto cut = [](const fs::path& path, double share) {
    const std::string bytes = read_text_file(path);
    const fs::path out = path.parent_path() / ("cut_" + path.filename().string());
    write_text_file(
        out, bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    return out;
  };
  const Image::Pointer image = head(turned());
  expect_refused("missing", scratch("absent.nii"), "no such file");
  fs::create_directories(scratch("empty"));
  expect_refused("empty folder", scratch("empty"), "no DICOM");
  write_text_file(scratch("notes.txt"), "not a CT");
  expect_refused("suffix", scratch("notes.txt"), "no CT format");
  for (const char* name : {"text.nii", "text.nii.gz", "text.nrrd", "text.mha", "text.dcm"}) {
    write_text_file(scratch(name), "not a CT");
    expect_refused(name, scratch(name), "");
  }
  write_text_file(scratch("text.inv3"), "not a CT");
  expect_refused("text.inv3", scratch("text.inv3"), "no InVesalius project");
  for (const bool packed : {false, true})
    for (const double share : {0.2, 0.6, 0.95}) {
      const auto refused = [&](auto io, const char* name) {
        using Io = typename decltype(io)::ObjectType;
        expect_refused(fmt::format("{} packed {} cut at {}", name, packed, share),
                       cut(write<Io>(scratch(name), image, packed), share), "");
      };
      refused(itk::NiftiImageIO::New(), "h.nii");
      refused(itk::NiftiImageIO::New(), "h.nii.gz");
      refused(itk::NrrdImageIO::New(), "h.nrrd");
      refused(itk::MetaImageIO::New(), "h.mha");
    }
  write<itk::MetaImageIO>(scratch("h.mhd"), image);
  fs::remove(scratch("h.raw"));
  expect_refused("mhd without its voxels", scratch("h.mhd"), "cut short");
  fs::copy_file(kCranium, scratch("c.inv3"), fs::copy_options::overwrite_existing);
  expect_refused("inv3", cut(scratch("c.inv3"), 0.1), "truncated");
}

TEST(CtVolume, RefusesVolumesThatAreNotInHounsfieldUnits) {
  const auto refused = [](const char* what, const Image::Pointer& image, const char* message) {
    expect_refused(what, write<itk::NrrdImageIO>(scratch("bad.nrrd"), image), message);
  };
  const auto fill = [](short low, short high) {
    const Image::Pointer image = head(Eigen::Matrix3d::Identity());
    image->FillBuffer(low);
    image->SetPixel({3, 3, 3}, high);
    return image;
  };
  refused("raw scanner values", fill(24, 2500), "rescale");
  refused("no bone", fill(-1000, 60), "no bone");

  using Flat = itk::Image<short, 2>;
  const auto flat = Flat::New();
  Flat::RegionType region;
  region.SetSize({4, 4});
  flat->SetRegions(region);
  flat->Allocate();
  expect_refused("picture", write<itk::NrrdImageIO>(scratch("flat.nrrd"), flat), "three axes");

  using Colour = itk::Image<itk::Vector<float, 3>, 3>;
  const auto colour = Colour::New();
  Colour::RegionType box;
  box.SetSize({4, 4, 4});
  colour->SetRegions(box);
  colour->Allocate();
  expect_refused("colour", write<itk::MetaImageIO>(scratch("colour.mha"), colour), "colour");

  using Real = itk::Image<float, 3>;
  const auto real = Real::New();
  real->SetRegions(box);
  real->Allocate();
  real->FillBuffer(std::nanf(""));
  expect_refused("not a number", write<itk::NrrdImageIO>(scratch("nan.nrrd"), real), "finite");

  const std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "DimSize = 2 2 2\nElementType = MET_SHORT\nElementSpacing = {}\nElementDataFile = LOCAL\n";
  write_text_file(scratch("zero.mha"),
                  fmt::format(fmt::runtime(header), "1 1 0") + std::string(16, '\1'));
  expect_refused("zero spacing", scratch("zero.mha"), "spacing");
  write_text_file(scratch("metres.mha"),
                  fmt::format(fmt::runtime(header), "1 1 500") + std::string(16, '\1'));
  expect_refused("far too large", scratch("metres.mha"), "spacing");
}

TEST(DicomSeries, IsChosenByUidDescriptionOrOneOfItsFiles) {
  const fs::path folder = scratch("two_series");
  write_dicom(folder, {});
  Dicom other;
  other.uid = "1.2.826.0.1.3680043.2.1125.2";
  other.description = "Head soft";
  other.prefix = "b";
  other.slices = 4;
  write_dicom(folder, other);
  expect_refused("two series", folder, "Head bone");
  expect_refused("two series", folder, "Head soft");
  expect_refused("no such series", folder, "Head soft", {"Knee"});
  EXPECT_EQ(read_ct(folder, {other.uid}).hounsfield.shape().size[2], 4);
  EXPECT_EQ(read_ct(folder, {"Head bone"}).hounsfield.shape().size[2], 5);
  EXPECT_EQ(read_ct(folder, {"2"}).hounsfield.shape().size[2], 4);
  EXPECT_EQ(read_ct(folder / "b1.dcm").hounsfield.shape().size[2], 4);
}

TEST(DicomSeries, NamesWhatMakesItsGridIrregular) {
  struct Bad {
    const char* what;
    Dicom how;
    const char* message;
  };
  std::vector<Bad> table(6);
  table[0] = {"missing", {}, "1 missing between"};
  table[0].how.z_mm = [](int z) { return 1.25 * (z < 3 ? z : z + 1); };
  table[1] = {"mixed", {}, "mixed spacing"};
  table[1].how.z_mm = [](int z) { return 1.25 * (z < 3 ? z : z + 0.4 * (z - 2)); };
  table[2] = {"tilt", {}, "gantry tilt"};
  table[2].how.tilt_mm = 0.2;
  table[3] = {"doubled", {}, "one position"};
  table[3].how.z_mm = [](int z) { return 1.25 * (z == 3 ? 2 : z); };
  table[4] = {"mr", {}, "must be CT"};
  table[4].how.modality = "MR";
  table[5] = {"single", {}, "no volume"};
  table[5].how.slices = 1;
  for (const Bad& bad : table)
    expect_refused(bad.what, write_dicom(scratch(bad.what), bad.how), bad.message);

  Dicom fine;
  fine.prefix = "b";
  fine.pixel_mm = 0.4;
  fine.z_mm = [](int z) { return 20.0 + 1.25 * z; };
  write_dicom(scratch("sizes"), {});
  expect_refused("mixed pixel sizes", write_dicom(scratch("sizes"), fine), "mixed size");
}

TEST(DicomSeries, IsRefusedWhenASliceEndsEarly) {
  const fs::path folder = write_dicom(scratch("short"), {});
  EXPECT_EQ(read_ct(folder).hounsfield.shape().size[2], 5);
  const std::string whole = read_text_file(folder / "a3.dcm");
  for (const std::size_t missing : {1u, 20u, 84u}) {  // of 84 bytes of pixels
    write_text_file(folder / "a3.dcm", whole.substr(0, whole.size() - missing));
    expect_refused("cut slice", folder, "cut short: its header says 84");
  }
}

}  // namespace
}  // namespace osteomill::io
