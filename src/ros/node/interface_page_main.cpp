// Prints the page docs/interface.md, so that it can be made anew: interface_page > docs/interface.md
#include "interface_page.h"

#include <cstdio>

int main() { return std::fputs(deformable_surface::node::interfacePage().c_str(), stdout) < 0 ? 1 : 0; }
