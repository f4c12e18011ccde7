// Prints the page docs/parameters.md, so that it can be made anew: parameters_page > docs/parameters.md
#include "deformable_surface/io/scene.h"

#include <cstdio>

int main() { return std::fputs(deformable_surface::io::parametersPage().c_str(), stdout) < 0 ? 1 : 0; }
