// Quarters of two balls of radius 10 mm that touch at the origin, along z [m]: x = 0 and y = 0 are planes of symmetry.
//   gmsh -3 -format msh41 two_balls_solid.geo -o two_balls_solid.msh
// Tetrahedra with edges of 0.22 mm out to `touching`, farther away growing by `growth` per length up to 2.5 mm; those of
// the upper ball are a tenth longer. `-setnumber refinement 2` halves every edge. The caps, 0.4 rad of each ball, are the
// surfaces that may touch.
DefineConstant[ refinement = 1 ];
radius = 0.010; cap = 0.4; touching = 0.0013; growth = 0.35;
fine = 0.22e-3 / refinement; coarse = 2.5e-3 / refinement;

Mesh.Algorithm = 6;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

For body In {0 : 1}
  p = 100 * body;
  side = 2 * body - 1;  // the first ball lies below, the second above
  z = side * radius; rim = side * radius * (1 - Cos(cap));
  Point(p + 1) = {0, 0, 0};
  Point(p + 2) = {0, 0, z};
  Point(p + 3) = {radius * Sin(cap), 0, rim};
  Point(p + 4) = {0, radius * Sin(cap), rim};
  Point(p + 5) = {radius, 0, z};
  Point(p + 6) = {0, radius, z};
  Point(p + 7) = {0, 0, rim};
  Point(p + 8) = {0, 0, 2 * z};
  Circle(p + 1) = {p + 1, p + 2, p + 3};  Circle(p + 2) = {p + 1, p + 2, p + 4};
  Circle(p + 3) = {p + 3, p + 7, p + 4};
  Circle(p + 4) = {p + 3, p + 2, p + 5};  Circle(p + 5) = {p + 4, p + 2, p + 6};
  Circle(p + 6) = {p + 5, p + 2, p + 6};
  Circle(p + 7) = {p + 5, p + 2, p + 8};  Circle(p + 8) = {p + 6, p + 2, p + 8};
  Line(p + 9) = {p + 8, p + 1};
  Curve Loop(p + 1) = {p + 1, p + 3, -(p + 2)};                Surface(p + 1) = {p + 1};
  Curve Loop(p + 2) = {p + 4, p + 6, -(p + 5), -(p + 3)};      Surface(p + 2) = {p + 2};
  Curve Loop(p + 3) = {p + 7, -(p + 8), -(p + 6)};             Surface(p + 3) = {p + 3};
  Curve Loop(p + 4) = {p + 1, p + 4, p + 7, p + 9};            Plane Surface(p + 4) = {p + 4};
  Curve Loop(p + 5) = {p + 2, p + 5, p + 8, p + 9};            Plane Surface(p + 5) = {p + 5};
  Surface Loop(p + 1) = {p + 1, p + 2, p + 3, p + 4, p + 5};   Volume(p + 1) = {p + 1};
EndFor

Field[1] = MathEval;
Field[1].F = Sprintf("(1 + 0.1 * (z + Abs(z)) / (2 * Abs(z) + 1e-9)) * Min(%g, %g + %g * Max(Sqrt(x^2 + y^2 + z^2) - %g, 0))", coarse, fine, growth, touching);
Background Field = 1;

Physical Volume("lower") = {1};
Physical Volume("upper") = {101};
Physical Surface("lower_cap") = {1};
Physical Surface("upper_cap") = {101};
Physical Surface("lower_y") = {4};  // y = 0
Physical Surface("upper_y") = {104};
Physical Surface("lower_x") = {5};  // x = 0
Physical Surface("upper_x") = {105};
