// Makes uname() name the kernel of RHEL 7, for without_new_system_calls.py: libraries ask it which
// system calls they may do without.
#define _GNU_SOURCE
#include <string.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <unistd.h>

int uname(struct utsname* name) {
  const long result = syscall(SYS_uname, name);
  if (result == 0) strcpy(name->release, "3.10.0-1160.el7.x86_64");
  return (int)result;
}
