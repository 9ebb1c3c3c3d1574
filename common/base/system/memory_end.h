// How a process ends when no memory is left, as under `ulimit -v`: by one line for people, never by
// a hang or an abort without a word.
#pragma once

#include <cstdint>
#include <string_view>

namespace parallax {

// Ends the process, from now on, when an allocation fails, and when a system call that ErrnoError
// reports lacked memory: for programs that cannot go on without. Writes "error: memory ran out;
// ..." to stderr and exits with `exit_status` at once; nothing is flushed, destroyed or waited for.
// Does what NameUncaughtExceptions does, too.
void EndWhenMemoryRunsOut(std::string_view program, int exit_status);

// Makes uncaught exceptions and aborts end the process with a line that names them, memory that ran
// out among them: for programs that catch failed allocations where they can go on.
void NameUncaughtExceptions(std::string_view program);

// Returns the bytes of address space that `ulimit -v` allows a process; 0 if it sets no limit.
// Allocates nothing.
int64_t AddressSpaceLimit();

// Ends the process if EndWhenMemoryRunsOut was called. ErrnoError calls it at ENOMEM.
void EndIfMemoryIsNeeded();

}  // namespace parallax
