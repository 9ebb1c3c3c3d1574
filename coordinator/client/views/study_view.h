// Shows a study's status as text.
#pragma once

#include <string>
#include <vector>

#include "coordinator/client/views/terminal.h"
#include "coordinator/view/status_view.h"
#include "parallax/v1/service.pb.h"

namespace parallax::client {

// Returns a line for each kind of job without scenes that the study has: "train: 2 done, 1 running,
// 3 to come".
std::vector<std::string> OtherJobLines(const v1::StudyStatus& study);
// Returns whether jobs without scenes, such as trainings, run or are to come.
bool HasOtherJobs(const v1::StudyStatus& study);
// Returns lines with the limit of an unfinished study and the limit that holds it back now.
std::vector<std::string> LimitLines(const v1::StudyStatus& study);

// Describes READY jobs that do not run: "4 train jobs wait: no connected worker for train jobs has
// the trainer raftstereo (worker --allow-trainers raftstereo)".
std::string WaitingText(const v1::WaitingJobs& jobs);
// Returns whether somebody must do something before these jobs can run. Time alone helps those that
// wait for a free worker or a limit; a study is paused on purpose.
bool WantsAttention(const v1::WaitingJobs& jobs);
Tone StateTone(v1::StudyState state);
// Returns the state's name in the state's tone.
std::string PaintedState(const Terminal& terminal, v1::StudyState state);

// Prints a heading, a table with a row for each variant, and problems.
void PrintStudy(const Terminal& terminal, const v1::StudyStatus& study);
void PrintStudyList(const Terminal& terminal, const v1::ListStudiesReply& list);
// Returns whether the job is one of a scene's.
bool HasScene(const v1::JobStatus& job);
// Returns where a job belongs, for messages: "narrow scene 3"; the variant alone for a job without
// a scene and for a variant that gave up.
std::string PlaceOf(const std::string& variant, const v1::JobProblem& problem);
std::string PlaceOf(const v1::JobStatus& job);
// Returns lines with the newest problems of all variants, at most `most`, and with the number of
// those left out.
std::vector<std::string> ProblemLines(const Terminal& terminal, const v1::StudyStatus& study,
                                      size_t most);

}  // namespace parallax::client
