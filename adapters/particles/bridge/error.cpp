// LIGGGHTS ends the process on any error.  The library calls these functions through its symbol
// table, and this module stands before it in the look-up order, so that an error becomes a C++
// exception (and, through pybind11, a Python one) and the process lives on.
//
// Error::one is called on a single rank: the others may wait in a collective call for ever, so a
// parallel run must abort its communicator when the exception is not handled.

#include "error.h"

#include <stdexcept>
#include <string>

#include "compute.h"
#include "fix.h"

namespace {

[[noreturn]] void raise(const char *file, int line, const std::string &what) {
  throw std::runtime_error(what + " (" + file + ":" + std::to_string(line) + ")");
}

}  // namespace

namespace LAMMPS_NS {

void Error::all(const char *file, int line, const char *what) { raise(file, line, what); }

void Error::one(const char *file, int line, const char *what) { raise(file, line, what); }

void Error::universe_all(const char *file, int line, const char *what) { raise(file, line, what); }

void Error::universe_one(const char *file, int line, const char *what) { raise(file, line, what); }

void Error::fix_error(const char *file, int line, Fix *fix, const char *what) {
  fix_error(file, line, fix, fix->style, what);
}

void Error::fix_error(const char *file, int line, Fix *fix, const char *style, const char *what) {
  raise(file, line, std::string("fix ") + style + " (id " + fix->id + "): " + what);
}

void Error::compute_error(const char *file, int line, Compute *compute, const char *what) {
  raise(file, line, std::string("compute ") + compute->style + ": " + what);
}

void Error::done() { raise("", 0, "LIGGGHTS was told to quit"); }

}  // namespace LAMMPS_NS
