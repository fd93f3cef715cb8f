#pragma once

#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace flipflow {

// Elastic energy (J) of the particle-particle contacts of this rank: Hertz in normal direction
// and, with `tangential_spring`, the spring of LIGGGHTS's tangential model "history".  A contact
// with a particle of another rank counts half.  `e_star_Pa`, `g_star_Pa`: effective moduli by
// material pair, row-major (types x types).
double pair_elastic_energy_J(LAMMPS_NS::LAMMPS &lmp, const std::vector<double> &e_star_Pa,
                             const std::vector<double> &g_star_Pa, bool tangential_spring);

}  // namespace flipflow
