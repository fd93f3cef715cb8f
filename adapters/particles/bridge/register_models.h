#pragma once

namespace flipflow {

// Makes LIGGGHTS know `model jkr`, with `tangential history` and `rolling_friction cdt` or `epsd2`
// if wanted.  Its models are templates that LIGGGHTS instantiates when it is built; those with ours
// are instantiated here.  Calls after the first do nothing.
void register_contact_models();

}  // namespace flipflow
