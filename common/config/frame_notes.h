// Names that worker and coordinator share for what an attempt leaves until its job is done.
#pragma once

namespace parallax {

// Folder of an attempt that has, until the job is done, a note for each frame that is whole.
inline constexpr char kFrameNotes[] = "finished";
// Folder of a training's attempt that has, until the job is done, its checkpoints.
inline constexpr char kResumeFolder[] = "resume";

}  // namespace parallax
