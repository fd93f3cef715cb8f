// adapters.panel._kernel: the explicit loops of panels, compiled.

#include "modules.h"

PYBIND11_MODULE(_kernel, module) {
  flipflow::add_chain(module);
  flipflow::add_sheet(module);
}
