// Two short cylinders in the (r, z) half plane [m]; the upper one has a rounded rim.
// gmsh -2 two_cylinders.geo -format msh41 -o two_cylinders.msh
SetFactory("Built-in");
radius = 5e-3;
rim = 1e-3;
size = 2.5e-3;

// striker: z from 0 to 8 mm, its zone near the contact separate
Point(1) = {0, 0, 0, size};
Point(2) = {radius - rim, 0, 0, size};
Point(3) = {radius - rim, rim, 0, size};
Point(4) = {radius, rim, 0, size};
Point(5) = {radius, 4e-3, 0, size};
Point(6) = {0, 4e-3, 0, size};
Point(7) = {radius, 8e-3, 0, size};
Point(8) = {0, 8e-3, 0, size};
Line(1) = {1, 2};
Circle(2) = {2, 3, 4};
Line(3) = {4, 5};
Line(4) = {5, 6};
Line(5) = {6, 1};
Line(6) = {5, 7};
Line(7) = {7, 8};
Line(8) = {8, 6};
Curve Loop(1) = {1, 2, 3, 4, 5};
Plane Surface(1) = {1};
Curve Loop(2) = {-4, 6, 7, 8};
Plane Surface(2) = {2};

// target: z from -4 mm to 0, own nodes on the contact surface, clockwise on purpose
Point(11) = {0, 0, 0, size};
Point(12) = {radius, 0, 0, size};
Point(13) = {radius, -4e-3, 0, size};
Point(14) = {0, -4e-3, 0, size};
Line(11) = {11, 12};
Line(12) = {12, 13};
Line(13) = {13, 14};
Line(14) = {14, 11};
Curve Loop(3) = {11, 12, 13, 14};
Plane Surface(3) = {3};
Transfinite Surface {3};

Recombine Surface {1, 2, 3};
Mesh.RecombinationAlgorithm = 1;
Physical Surface("striker") = {1, 2};
Physical Surface("contact zone") = {1};
Physical Surface("target") = {3};
Physical Curve("striker_face") = {1};
Physical Curve("target_face") = {11};
Physical Curve("free") = {3, 6, 12};
Physical Curve("axis") = {5, 8, 14};
