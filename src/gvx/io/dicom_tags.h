/// \file
/// The DICOM elements that gvx reads (PS3.6): their tags, names, and how their values are written.
#pragma once

#include "gvx/io/dicom_dataset.h"

namespace gvx::io {

enum class DicomValue { text, u16, u32, f32, f64, tag, bytes, sequence };

struct DicomTagEntry {
  DicomTag tag;
  DicomValue value;
  const char* name;
};

/// Null for an element that gvx does not use.
const DicomTagEntry* find_dicom_tag(DicomTag tag);

namespace tag {

inline constexpr DicomTag kMetaLength = 0x00020000, kMediaStorageClass = 0x00020002,
                          kTransferSyntax = 0x00020010, kImageType = 0x00080008, kSopClass = 0x00080016,
                          kAcquisitionTime = 0x00080032, kModality = 0x00080060,
                          kSeriesDescription = 0x0008103E, kSliceThickness = 0x00180050,
                          kEchoTime = 0x00180081, kEchoNumbers = 0x00180086,
                          kSpacingBetweenSlices = 0x00180088, kTriggerTime = 0x00181060,
                          kGantryTilt = 0x00181120, kImagerPixelSpacing = 0x00181164,
                          kAcquisitionDateTime = 0x00189074, kEffectiveEchoTime = 0x00189082,
                          kBValue = 0x00189087, kEchoSequence = 0x00189114, kDiffusionSequence = 0x00189117,
                          kCardiacTriggerSequence = 0x00189118, kCardiacDelay = 0x00209153,
                          kSeriesUid = 0x0020000E, kSeriesNumber = 0x00200011,
                          kAcquisitionNumber = 0x00200012, kInstanceNumber = 0x00200013,
                          kPosition = 0x00200032, kOrientation = 0x00200037, kTemporalPosition = 0x00200100,
                          kSliceLocation = 0x00201041, kFrameContentSequence = 0x00209111,
                          kPlanePositionSequence = 0x00209113, kPlaneOrientationSequence = 0x00209116,
                          kTemporalIndex = 0x00209128, kDimensionIndexValues = 0x00209157,
                          kDimensionIndexPointer = 0x00209165, kDimensionIndexSequence = 0x00209222,
                          kSamplesPerPixel = 0x00280002, kPhotometric = 0x00280004,
                          kPlanarConfiguration = 0x00280006, kNumberOfFrames = 0x00280008,
                          kFrameIncrementPointer = 0x00280009, kRows = 0x00280010, kColumns = 0x00280011,
                          kPixelSpacing = 0x00280030, kBitsAllocated = 0x00280100, kBitsStored = 0x00280101,
                          kHighBit = 0x00280102, kPixelRepresentation = 0x00280103, kIntercept = 0x00281052,
                          kSlope = 0x00281053, kRescaleType = 0x00281054, kRedDescriptor = 0x00281101,
                          kRedData = 0x00281201, kModalityLut = 0x00283000,
                          kPixelMeasuresSequence = 0x00289110, kValueTransformationSequence = 0x00289145,
                          kSliceVector = 0x00540080, kTimeSliceVector = 0x00540100,
                          kDetectorSequence = 0x00540022, kGridOffsets = 0x3004000C,
                          kDoseScaling = 0x3004000E, kSharedGroups = 0x52009229, kPerFrameGroups = 0x52009230,
                          kMosaicImages = 0x0019100A;

}  // namespace tag
}  // namespace gvx::io
