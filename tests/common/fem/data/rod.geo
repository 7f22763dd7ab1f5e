// A rod of two zones along x [m].
// gmsh -1 rod.geo -format msh41 -o rod.msh
Point(1) = {0.1, 0, 0, 0.02};
Point(2) = {0.2, 0, 0, 0.01};
Point(3) = {0.25, 0, 0, 0.01};
Line(1) = {1, 2};
Line(2) = {3, 2};
Physical Curve("rod") = {1, 2};
Physical Curve("tip") = {2};
Physical Point("support") = {1};
Physical Point("impact_end") = {3};
