// Two balls of radius 10 mm that touch on the axis, axisymmetric: x is r, y is z [m]. Fine where they touch.
//   gmsh -2 -format msh41 two_balls.geo -o two_balls.msh
// Recombined quadrilaterals of 0.1 mm out to `touching`, farther away growing by `growth` per length up to 1 mm.
// `-setnumber refinement 2` halves every element. The caps, 0.5 rad of each ball, are the surfaces that may touch;
// their nodes lie at different heights, those of the upper ball at `coarser` times the distance.
DefineConstant[ refinement = 1 ];
radius = 0.010; cap = 0.5; touching = 0.0015; growth = 0.25; coarser = 1.2;
fine = 0.1e-3 / refinement; coarse = 1e-3 / refinement;

Mesh.Algorithm = 6;
Mesh.RecombineAll = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

For body In {0 : 1}
  p = 100 * body;
  side = 2 * body - 1;  // the first ball lies below, the second above
  Point(p + 1) = {0, 0, 0};
  Point(p + 2) = {0, side * radius, 0};
  Point(p + 3) = {radius * Sin(cap), side * radius * (1 - Cos(cap)), 0};
  Point(p + 4) = {radius, side * radius, 0};
  Point(p + 5) = {0, side * 2 * radius, 0};
  Circle(p + 1) = {p + 1, p + 2, p + 3};
  Circle(p + 2) = {p + 3, p + 2, p + 4};
  Circle(p + 3) = {p + 4, p + 2, p + 5};
  Line(p + 4) = {p + 5, p + 1};
  Curve Loop(p + 1) = {p + 1, p + 2, p + 3, p + 4};
  Plane Surface(p + 1) = {p + 1};
EndFor

Field[1] = MathEval;
Field[1].F = Sprintf("(%g + %g * (y + Abs(y)) / (2 * Abs(y) + 1e-9)) * Min(%g, %g + %g * Max(Sqrt(x^2 + y^2) - %g, 0))", 1, coarser - 1, coarse, fine, growth, touching);
Background Field = 1;

Physical Surface("lower") = {1};
Physical Surface("upper") = {101};
Physical Curve("lower_cap") = {1};
Physical Curve("upper_cap") = {101};
