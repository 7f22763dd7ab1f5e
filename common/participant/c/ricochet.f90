! Take part in a coupled run of ricochet from Fortran: the functions of ricochet.h, which says what each does, its units,
! shapes and error returns. Texts end with c_null_char, arrays of link values are (components, nodes), bodies are counted
! from 0. Compile this file with yours and link with -lricochet.
module ricochet
  use, intrinsic :: iso_c_binding
  implicit none

  interface
    function ricochet_open(role, solver, components) bind(c) result(loop)
      import :: c_char, c_int, c_ptr
      character(kind=c_char), intent(in) :: role(*), solver(*)
      integer(c_int), value :: components
      type(c_ptr) :: loop
    end function

    function ricochet_scene(loop) bind(c) result(text)
      import :: c_ptr
      type(c_ptr), value :: loop
      type(c_ptr) :: text
    end function

    function ricochet_name(loop) bind(c) result(text)
      import :: c_ptr
      type(c_ptr), value :: loop
      type(c_ptr) :: text
    end function

    function ricochet_add_body(loop, body) bind(c) result(error)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: loop
      character(kind=c_char), intent(in) :: body(*)
      integer(c_int) :: error
    end function

    function ricochet_set_interface(loop, nodes, body, position, mass) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int), value :: nodes
      integer(c_int), intent(in) :: body(*)
      real(c_double), intent(in) :: position(*), mass(*)
      integer(c_int) :: error
    end function

    function ricochet_set_critical_time_step(loop, step_s) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), value :: step_s
      integer(c_int) :: error
    end function

    function ricochet_add_capability(loop, capability) bind(c) result(error)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: loop
      character(kind=c_char), intent(in) :: capability(*)
      integer(c_int) :: error
    end function

    function ricochet_add_column(loop, column) bind(c) result(error)
      import :: c_char, c_int, c_ptr
      type(c_ptr), value :: loop
      character(kind=c_char), intent(in) :: column(*)
      integer(c_int) :: error
    end function

    function ricochet_initialize(loop, value, record) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), intent(in) :: value(*), record(*)
      integer(c_int) :: error
    end function

    function ricochet_window_size(loop) bind(c) result(size_s)
      import :: c_double, c_ptr
      type(c_ptr), value :: loop
      real(c_double) :: size_s
    end function

    function ricochet_substeps(loop) bind(c) result(substeps)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: substeps
    end function

    function ricochet_driven_by_force(loop) bind(c) result(by_force)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: by_force
    end function

    function ricochet_interface_mass(loop, mass) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), intent(out) :: mass(*)
      integer(c_int) :: error
    end function

    function ricochet_directions(loop, directions) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), intent(out) :: directions(*)
      integer(c_int) :: error
    end function

    function ricochet_scene_position(loop, position) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), intent(out) :: position(*)
      integer(c_int) :: error
    end function

    function ricochet_progress(loop, doing, share_done) bind(c) result(error)
      import :: c_char, c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      character(kind=c_char), intent(in) :: doing(*)
      real(c_double), value :: share_done
      integer(c_int) :: error
    end function

    function ricochet_ongoing(loop) bind(c) result(ongoing)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: ongoing
    end function

    function ricochet_max_time_step(loop) bind(c) result(step_s)
      import :: c_double, c_ptr
      type(c_ptr), value :: loop
      real(c_double) :: step_s
    end function

    function ricochet_must_save(loop) bind(c) result(must)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: must
    end function

    function ricochet_must_restore(loop) bind(c) result(must)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: must
    end function

    function ricochet_read(loop, link) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), intent(out) :: link(*)
      integer(c_int) :: error
    end function

    ! velocity, acceleration: leave them out if driven by displacement.
    function ricochet_write(loop, value, velocity, acceleration, record) bind(c) result(error)
      import :: c_double, c_int, c_ptr
      type(c_ptr), value :: loop
      real(c_double), intent(in) :: value(*), record(*)
      real(c_double), intent(in), optional :: velocity(*), acceleration(*)
      integer(c_int) :: error
    end function

    function ricochet_advance(loop) bind(c) result(error)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: error
    end function

    function ricochet_close(loop) bind(c) result(error)
      import :: c_int, c_ptr
      type(c_ptr), value :: loop
      integer(c_int) :: error
    end function
  end interface
end module ricochet
