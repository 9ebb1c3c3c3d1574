// The name that worker and coordinator share for what an attempt notes of its finished frames.
#pragma once

namespace parallax {

// Folder of an attempt that has, until the job is done, a note for each frame that is whole.
inline constexpr char kFrameNotes[] = "finished";

}  // namespace parallax
