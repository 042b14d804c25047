#include "gvx/io/format_table.h"

#include <algorithm>

namespace gvx::io {
namespace {

using namespace std::string_view_literals;

constexpr auto kNotYet = "is not read yet"sv;
constexpr auto kNoVolume = "is neither a volume nor a mesh"sv;

constexpr auto kParaView = "convert it to NRRD, NIfTI or MetaImage, for example with ParaView or 3D Slicer"sv;
constexpr auto kSlicer = "convert it to NRRD or NIfTI, for example with 3D Slicer"sv;
constexpr auto kFiji = "save it as NRRD, for example with Fiji and Bio-Formats"sv;
constexpr auto kImages =
    "open the whole stack as an image sequence and save it as one NRRD file, for example with Fiji"sv;
constexpr auto kNumpy =
    "write its array as NRRD or raw samples, for example with Python (numpy and pynrrd, or numpy.tofile)"sv;
constexpr auto kHdf5 =
    "write its array as NRRD or raw samples, for example with Python (h5py and pynrrd) or Fiji"sv;
constexpr auto kVdb = "sample its grid to NRRD or raw samples, for example with Python (pyopenvdb)"sv;
constexpr auto kZarr = "write one level of it as NRRD, for example with Python (zarr and pynrrd) or Fiji"sv;
constexpr auto kMesh = "convert it to PLY, OBJ, STL or glTF, for example with MeshLab or Blender"sv;
constexpr auto kBlender = "export it as glTF or PLY, for example with Blender"sv;
constexpr auto kCad = "export a triangle mesh (STL or PLY) from a CAD program such as FreeCAD"sv;
constexpr auto kPoints =
    "make a mesh of its points and save it as PLY, for example with CloudCompare or MeshLab"sv;
constexpr auto kUnpack = "unpack it and name the file in it"sv;
constexpr auto kSlide = "save the region as a stack and then as NRRD, for example with QuPath or Fiji"sv;

constexpr auto kHdf5Mark = "\x89HDF\r\n\x1a\n"sv;
constexpr auto kZipMark = "PK\x03\x04"sv;

constexpr std::array<Magic, 4> kHdf5Magic = {
    {{kHdf5Mark, 0}, {kHdf5Mark, 512}, {kHdf5Mark, 1024}, {kHdf5Mark, 2048}}};
constexpr std::array<Magic, 4> kTiffMagic = {
    {{"II*\0"sv, 0}, {"MM\0*"sv, 0}, {"II+\0\x08\0\0\0"sv, 0}, {"MM\0+\0\x08\0\0"sv, 0}}};

constexpr Format kFormats[] = {
    // What gvx reads.
    {FileKind::store, "A gvx store", "gvx stores", ".gvx", "", "", {{{"GVXSTORE"sv, 0}}}},
    {FileKind::nrrd, "NRRD", "NRRD files", ".nrrd .nhdr", "", "", {{{"NRRD000"sv, 0}}}},
    {FileKind::nifti,
     "NIfTI",
     "NIfTI files",
     ".nii .hdr .img",
     "",
     "",
     {{{"n+1\0"sv, 344}, {"ni1\0"sv, 344}, {"n+2\0\r\n\x1a\n"sv, 4}, {"ni2\0\r\n\x1a\n"sv, 4}}}},
    {FileKind::metaimage,
     "MetaImage",
     "MetaImage files",
     ".mha .mhd",
     "",
     "",
     {{{"ObjectType"sv, 0}, {"NDims"sv, 0}}}},
    {FileKind::raw, "Raw samples", "raw files", ".raw .bin .dat", "", ""},
    {FileKind::mesh, "A PLY mesh", "PLY meshes", ".ply", "", "", {{{"ply\n"sv, 0}, {"ply\r"sv, 0}}}},
    {FileKind::mesh, "A glTF scene", "glTF scenes", ".gltf .glb", "", "", {{{"glTF"sv, 0}}}},
    {FileKind::mesh, "An OBJ or STL mesh", "meshes", ".obj .stl", "", ""},

    // Volumes of medicine.
    {FileKind::dicom, "DICOM", "DICOM files", ".dcm .dicom .ima", "", "", {{{"DICM"sv, 128}}}},
    {FileKind::other, "A FreeSurfer volume (MGH)", "FreeSurfer volumes", ".mgz .mgh", kNotYet,
     "convert it to NIfTI, for example with mri_convert or Python (nibabel)"},
    {FileKind::other, "A MINC volume", "MINC volumes", ".mnc .mnc2", kNotYet,
     "convert it to NIfTI, for example with mnc2nii"},
    {FileKind::other, "A Philips PAR/REC volume", "PAR/REC files", ".par .rec", kNotYet,
     "convert it to NIfTI, for example with dcm2niix"},
    {FileKind::other, "An ECAT volume", "ECAT files", "", kNotYet, kSlicer, {{{"MATRIX7"sv, 0}}}},
    {FileKind::other,
     "A Scanco volume",
     "Scanco volumes",
     ".isq .aim",
     kNotYet,
     kSlicer,
     {{{"CTDATA-HEADER_V1"sv, 0}}}},

    // Of microscopes. Several are TIFF or HDF5 inside.
    {FileKind::other, "A slide of a slide scanner", "slides", ".svs .ndpi .scn .vms .bif .mrxs",
     "is one plane, not a volume", kSlide},
    {FileKind::other, "A Zeiss LSM image", "LSM images", ".lsm", kNotYet, kFiji, kTiffMagic, true},
    {FileKind::tiff, "TIFF", "TIFF files", ".tif .tiff .btf .tf8", kNotYet, kFiji, kTiffMagic},
    {FileKind::other, "A Zeiss CZI image", "CZI images", ".czi", kNotYet, kFiji, {{{"ZISRAWFILE"sv, 0}}}},
    {FileKind::other, "A Leica LIF image", "LIF images", ".lif", kNotYet, kFiji},
    {FileKind::other,
     "A Nikon ND2 image",
     "ND2 images",
     ".nd2",
     kNotYet,
     kFiji,
     {{{"\xda\xce\xbe\x0a"sv, 0}}}},
    {FileKind::other, "An Olympus image", "Olympus images", ".oib .oif .oir .vsi", kNotYet, kFiji},
    {FileKind::other, "A Gatan DM image", "Gatan images", ".dm3 .dm4", kNotYet, kFiji},
    {FileKind::other, "An Imaris image (HDF5)", "Imaris images", ".ims", kNotYet, kFiji, kHdf5Magic, true},
    {FileKind::other, "An NWB file (HDF5)", "NWB files", ".nwb", kNotYet, kHdf5, kHdf5Magic, true},
    {FileKind::other,
     "An MRC density map",
     "MRC maps",
     ".mrc .map .ccp4 .rec .ali",
     kNotYet,
     "convert it to NRRD or raw samples, for example with Python (mrcfile and pynrrd) or Fiji",
     {{{"MAP "sv, 208}}}},

    // Of simulations and programs.
    {FileKind::other,
     "A MATLAB file",
     "MATLAB files",
     ".mat",
     kNotYet,
     "write its array as NRRD or raw samples, for example with MATLAB's fwrite or Python (scipy.io and "
     "pynrrd)",
     {{{"MATLAB 5.0"sv, 0}, {"MATLAB 7.3"sv, 0}}}},
    {FileKind::other, "HDF5", "HDF5 files", ".h5 .hdf5 .hdf .he5 .ims .nwb .nc4", kNotYet, kHdf5, kHdf5Magic},
    {FileKind::other,
     "NetCDF",
     "NetCDF files",
     ".nc .cdf",
     kNotYet,
     "write its array as NRRD or raw samples, for example with Python (xarray and pynrrd) or ParaView",
     {{{"CDF\x01"sv, 0}, {"CDF\x02"sv, 0}, {"CDF\x05"sv, 0}}}},
    {FileKind::other, "A NumPy array", "NumPy arrays", ".npy", kNotYet, kNumpy, {{{"\x93NUMPY"sv, 0}}}},
    {FileKind::other, "A NumPy archive", "NumPy archives", ".npz", kNotYet, kNumpy, {{{kZipMark, 0}}}, true},
    {FileKind::other, "OpenVDB", "VDB files", ".vdb", kNotYet, kVdb, {{{"\x20\x42\x44\x56\0\0\0\0"sv, 0}}}},
    {FileKind::other, "NanoVDB", "NanoVDB files", ".nvdb", kNotYet, kVdb, {{{"NanoVDB"sv, 0}}}},
    {FileKind::other,
     "FITS",
     "FITS files",
     ".fits .fit .fts",
     kNotYet,
     "write its array as NRRD or raw samples, for example with Python (astropy and pynrrd)",
     {{{"SIMPLE  ="sv, 0}}}},
    {FileKind::other, "VTK image data", "VTK images", ".vti .pvti", kNotYet, kParaView},
    {FileKind::other, "A VTK mesh", "VTK meshes", ".vtp .pvtp", kNotYet,
     "convert it to PLY or STL, for example with ParaView"},
    {FileKind::other, "A VTK grid", "VTK grids", ".vtu .pvtu .vtr .pvtr .vts .pvts .vtm .pvd", kNotYet,
     "resample it to an image in ParaView and save that as NRRD or MetaImage"},
    {FileKind::other,
     "A legacy VTK file",
     "VTK files",
     ".vtk",
     kNotYet,
     "save it from ParaView: an image as NRRD or MetaImage, a mesh as PLY",
     {{{"# vtk DataFile"sv, 0}}}},
    {FileKind::other,
     "An Amira file",
     "Amira files",
     ".am",
     kNotYet,
     kParaView,
     {{{"# AmiraMesh"sv, 0}, {"# Avizo"sv, 0}}}},
    {FileKind::other,
     "A PVM volume",
     "PVM volumes",
     ".pvm",
     kNotYet,
     "convert it to raw samples with pvm2raw",
     {{{"DDS v3"sv, 0}, {"PVM"sv, 0}}}},
    {FileKind::other,
     "A MagicaVoxel scene",
     "MagicaVoxel scenes",
     ".vox",
     kNotYet,
     "export it as OBJ or PLY from MagicaVoxel, or its voxels as raw samples with Python",
     {{{"VOX \x96"sv, 0}, {"VOX \xc8"sv, 0}}}},
    {FileKind::other, "A volume header of VolView or Voreen", "headers", ".vvd .vol .vgi", kNotYet,
     "name its raw file instead and say its shape (--dims, --dtype)"},
    {FileKind::other,
     "Zipped Zarr",
     "Zarr archives",
     ".zarr.zip .ozx",
     kNotYet,
     kZarr,
     {{{kZipMark, 0}}},
     true},

    // Meshes, scenes and points.
    {FileKind::other, "A 3MF mesh", "3MF meshes", ".3mf", kNotYet, kMesh, {{{kZipMark, 0}}}, true},
    {FileKind::other,
     "An OFF mesh",
     "OFF meshes",
     ".off",
     kNotYet,
     kMesh,
     {{{"OFF\n"sv, 0}, {"OFF\r"sv, 0}, {"OFF "sv, 0}, {"COFF"sv, 0}}}},
    {FileKind::other, "An FBX scene", "FBX scenes", ".fbx", kNotYet, kBlender, {{{"Kaydara FBX"sv, 0}}}},
    {FileKind::other, "A COLLADA scene", "COLLADA scenes", ".dae", kNotYet, kBlender},
    {FileKind::other, "A Blender scene", "Blender scenes", ".blend", kNotYet, kBlender, {{{"BLENDER"sv, 0}}}},
    {FileKind::other, "A 3D Studio mesh", "3DS meshes", ".3ds", kNotYet, kMesh},
    {FileKind::other,
     "A USD scene",
     "USD scenes",
     ".usd .usda .usdc .usdz",
     kNotYet,
     kBlender,
     {{{"PXR-USDC"sv, 0}, {"#usda"sv, 0}}}},
    {FileKind::other, "An Alembic scene", "Alembic scenes", ".abc", kNotYet, kBlender, {{{"Ogawa"sv, 0}}}},
    {FileKind::other,
     "A VRML or X3D scene",
     "X3D scenes",
     ".wrl .x3d .x3dv",
     kNotYet,
     kMesh,
     {{{"#VRML"sv, 0}}}},
    {FileKind::other,
     "A mesh of this kind",
     "meshes",
     ".om .pm .ase .lwo .smd .md5mesh .x .xyz.mesh .ac .msh .mesh .zae",
     kNotYet,
     kMesh,
     {{{"$MeshFormat"sv, 0}}}},
    {FileKind::other,
     "A CAD model",
     "CAD models",
     ".step .stp .iges .igs .brep .dxf .dwg",
     kNotYet,
     kCad,
     {{{"ISO-10303-21"sv, 0}}}},
    {FileKind::other,
     "A point cloud",
     "point clouds",
     ".las .laz .e57 .pcd .xyz .pts .ptx .splat",
     kNotYet,
     kPoints,
     {{{"LASF"sv, 0}, {"ASTM-E57"sv, 0}, {"# .PCD"sv, 0}}}},

    // Pictures.
    {FileKind::other,
     "A PNG picture",
     "PNG pictures",
     ".png",
     "is one slice, not a volume",
     kImages,
     {{{"\x89PNG\r\n\x1a\n"sv, 0}}}},
    {FileKind::other,
     "A JPEG picture",
     "JPEG pictures",
     ".jpg .jpeg",
     "is one slice, not a volume",
     kImages,
     {{{"\xff\xd8\xff"sv, 0}}}},
    {FileKind::other,
     "A JPEG 2000 picture",
     "JPEG 2000 pictures",
     ".jp2 .j2k .jpx .j2c",
     "is one slice, not a volume",
     kImages,
     {{{"\0\0\0\x0cjP  "sv, 0}, {"\xff\x4f\xff\x51"sv, 0}}}},
    {FileKind::other,
     "A BMP picture",
     "BMP pictures",
     ".bmp",
     "is one slice, not a volume",
     kImages,
     {{{"BM"sv, 0}}},
     true},
    {FileKind::other,
     "An OpenEXR picture",
     "OpenEXR pictures",
     ".exr",
     "is one slice, not a volume",
     kImages,
     {{{"\x76\x2f\x31\x01"sv, 0}}}},
    {FileKind::other,
     "A GIF picture",
     "GIF pictures",
     ".gif",
     "is a picture, not a volume",
     kImages,
     {{{"GIF87a"sv, 0}, {"GIF89a"sv, 0}}}},
    {FileKind::other,
     "A WebP picture",
     "WebP pictures",
     ".webp",
     "is one slice, not a volume",
     kImages,
     {{{"WEBPVP8"sv, 8}}}},
    {FileKind::other, "A PNM picture", "PNM pictures", ".pgm .ppm .pbm .pnm .pfm",
     "is one slice, not a volume", kImages},
    {FileKind::other,
     "A picture",
     "pictures",
     ".tga .psd .svg .heic .avif .jxl .dds .ktx .ktx2",
     "is not a volume",
     kImages,
     {{{"8BPS"sv, 0}, {"DDS |\0"sv, 0}, {"#?RADIANCE"sv, 0}}}},
    {FileKind::other,
     "A film",
     "films",
     ".mp4 .avi .mov .mkv .webm",
     "is not a volume",
     kImages,
     {{{"ftyp"sv, 4}}}},

    // What is no volume at all.
    {FileKind::other,
     "A PDF document",
     "PDF documents",
     ".pdf",
     kNoVolume,
     "name the volume or mesh file itself",
     {{{"%PDF-"sv, 0}}}},
    {FileKind::other,
     "A tar archive",
     "tar archives",
     ".tar .tgz .inv3",
     "is not looked into",
     kUnpack,
     {{{"ustar"sv, 257}}}},
    {FileKind::other,
     "A ZIP archive",
     "ZIP archives",
     ".zip",
     "is not looked into",
     kUnpack,
     {{{kZipMark, 0}, {"PK\x05\x06"sv, 0}}}},
    {FileKind::other,
     "An archive",
     "archives",
     ".7z .rar .xz .zst .lz4 .lzma",
     "is not looked into",
     kUnpack,
     {{{"7z\xbc\xaf\x27\x1c"sv, 0},
       {"Rar!\x1a\x07"sv, 0},
       {"\xfd"
        "7zXZ\0"sv,
        0},
       {"\x28\xb5\x2f\xfd"sv, 0}}}},
    {FileKind::other,
     "A program",
     "programs",
     ".exe .so .dll",
     kNoVolume,
     "name the volume or mesh file itself",
     {{{"\x7f"
        "ELF"sv,
        0}}}},
    {FileKind::other, "A table", "tables", ".csv .tsv .xlsx .xls .ods", kNoVolume,
     "write its numbers as raw samples or NRRD, for example with Python (numpy and pynrrd)"},
    {FileKind::other, "Text", "text files", ".txt .md .log .rst .mtl .py .sh", kNoVolume,
     "name the volume or mesh file that it belongs to"},
};

}  // namespace

std::span<const Format> formats() {
  return kFormats;
}

bool has_magic(const Format& format, std::string_view head) {
  return std::any_of(format.magic.begin(), format.magic.end(), [&](const Magic& magic) {
    return !magic.bytes.empty() && head.size() >= magic.at + magic.bytes.size() &&
           head.substr(magic.at, magic.bytes.size()) == magic.bytes;
  });
}

bool has_ending(const Format& format, std::string_view name) {
  std::string_view endings = format.endings;
  while (!endings.empty()) {
    const std::size_t space = std::min(endings.find(' '), endings.size());
    if (space > 0 && name.ends_with(endings.substr(0, space))) return true;
    endings.remove_prefix(std::min(space + 1, endings.size()));
  }
  return false;
}

}  // namespace gvx::io
