#include "gvx/io/dicom_tags.h"

#include <algorithm>
#include <iterator>

namespace gvx::io {
namespace {

using enum DicomValue;

constexpr DicomTagEntry kTags[] = {
    {0x00020000, u32, "FileMetaInformationGroupLength"},
    {0x00020002, text, "MediaStorageSOPClassUID"},
    {0x00020010, text, "TransferSyntaxUID"},
    {0x00080008, text, "ImageType"},
    {0x00080016, text, "SOPClassUID"},
    {0x00080032, text, "AcquisitionTime"},
    {0x00080060, text, "Modality"},
    {0x0008103E, text, "SeriesDescription"},
    {0x00180050, text, "SliceThickness"},
    {0x00180081, text, "EchoTime"},
    {0x00180086, text, "EchoNumbers"},
    {0x00180088, text, "SpacingBetweenSlices"},
    {0x00181060, text, "TriggerTime"},
    {0x00181120, text, "GantryDetectorTilt"},
    {0x00181164, text, "ImagerPixelSpacing"},
    {0x00189074, text, "FrameAcquisitionDateTime"},
    {0x00189082, f64, "EffectiveEchoTime"},
    {0x00189087, f64, "DiffusionBValue"},
    {0x00189114, sequence, "MREchoSequence"},
    {0x00189117, sequence, "MRDiffusionSequence"},
    {0x00189118, sequence, "CardiacSynchronizationSequence"},
    {0x0019100A, u16, "NumberOfImagesInMosaic"},
    {0x0020000E, text, "SeriesInstanceUID"},
    {0x00200011, text, "SeriesNumber"},
    {0x00200012, text, "AcquisitionNumber"},
    {0x00200013, text, "InstanceNumber"},
    {0x00200032, text, "ImagePositionPatient"},
    {0x00200037, text, "ImageOrientationPatient"},
    {0x00200100, text, "TemporalPositionIdentifier"},
    {0x00201041, text, "SliceLocation"},
    {0x00209111, sequence, "FrameContentSequence"},
    {0x00209113, sequence, "PlanePositionSequence"},
    {0x00209116, sequence, "PlaneOrientationSequence"},
    {0x00209128, u32, "TemporalPositionIndex"},
    {0x00209153, f64, "NominalCardiacTriggerDelayTime"},
    {0x00209157, u32, "DimensionIndexValues"},
    {0x00209165, DicomValue::tag, "DimensionIndexPointer"},
    {0x00209222, sequence, "DimensionIndexSequence"},
    {0x00280002, u16, "SamplesPerPixel"},
    {0x00280004, text, "PhotometricInterpretation"},
    {0x00280006, u16, "PlanarConfiguration"},
    {0x00280008, text, "NumberOfFrames"},
    {0x00280009, DicomValue::tag, "FrameIncrementPointer"},
    {0x00280010, u16, "Rows"},
    {0x00280011, u16, "Columns"},
    {0x00280030, text, "PixelSpacing"},
    {0x00280100, u16, "BitsAllocated"},
    {0x00280101, u16, "BitsStored"},
    {0x00280102, u16, "HighBit"},
    {0x00280103, u16, "PixelRepresentation"},
    {0x00281052, text, "RescaleIntercept"},
    {0x00281053, text, "RescaleSlope"},
    {0x00281054, text, "RescaleType"},
    {0x00281101, u16, "RedPaletteColorLookupTableDescriptor"},
    {0x00281102, u16, "GreenPaletteColorLookupTableDescriptor"},
    {0x00281103, u16, "BluePaletteColorLookupTableDescriptor"},
    {0x00281201, u16, "RedPaletteColorLookupTableData"},
    {0x00281202, u16, "GreenPaletteColorLookupTableData"},
    {0x00281203, u16, "BluePaletteColorLookupTableData"},
    {0x00283000, sequence, "ModalityLUTSequence"},
    {0x00289110, sequence, "PixelMeasuresSequence"},
    {0x00289145, sequence, "PixelValueTransformationSequence"},
    {0x00291010, bytes, "CSAImageHeaderInfo"},
    {0x00291110, bytes, "CSAImageHeaderInfo"},
    {0x00291210, bytes, "CSAImageHeaderInfo"},
    {0x00540022, sequence, "DetectorInformationSequence"},
    {0x00540080, u16, "SliceVector"},
    {0x00540100, u16, "TimeSliceVector"},
    {0x3004000C, text, "GridFrameOffsetVector"},
    {0x3004000E, text, "DoseGridScaling"},
    {0x52009229, sequence, "SharedFunctionalGroupsSequence"},
    {0x52009230, sequence, "PerFrameFunctionalGroupsSequence"},
    {0x7FE00008, bytes, "FloatPixelData"},
    {0x7FE00009, bytes, "DoubleFloatPixelData"},
    {0x7FE00010, bytes, "PixelData"},
};

static_assert(std::is_sorted(std::begin(kTags), std::end(kTags),
                             [](const auto& a, const auto& b) { return a.tag < b.tag; }));

}  // namespace

const DicomTagEntry* find_dicom_tag(DicomTag tag) {
  const auto* at =
      std::lower_bound(std::begin(kTags), std::end(kTags), tag,
                       [](const DicomTagEntry& entry, DicomTag wanted) { return entry.tag < wanted; });
  return at != std::end(kTags) && at->tag == tag ? at : nullptr;
}

}  // namespace gvx::io
