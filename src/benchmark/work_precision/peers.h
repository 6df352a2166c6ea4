#pragma once

#include <string>
#include <vector>

#include "dials.h"
#include "scenes.h"
#include "stepper.h"

namespace clothsim::work_precision {

/// Another simulation of a trial's cloth, on the same axes.
struct Peer {
  std::string name;
  Dial dial;
  StepperMaker make;
};

/// The peers that can simulate `trial`; none where they were not found at build time.
std::vector<Peer> peers(const Trial& trial, bool quick);

}  // namespace clothsim::work_precision
