!> Names of the units of a run, where its scene or deck gives them. No value is converted.
module asperity_unit_names
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: axis_unit, dimension_of, has_units, units_in_words, unit_of, with_unit
  public :: is_number, is_length, is_force, is_area, is_pressure, is_moment

  !> Dimensions of quantities.
  enum, bind(c)
    enumerator :: is_number = 0, is_length, is_force, is_area, is_pressure, is_moment
  end enum

contains

  !> Whether the units have names.
  pure logical function has_units(scene_in)
    type(scene), intent(in) :: scene_in  !! what was solved

    has_units = scene_in%units(1) /= ''
  end function has_units

  !> `length mm, force N, area mm2, pressure N/mm2`.
  pure function units_in_words(scene_in) result(text)
    type(scene), intent(in) :: scene_in    !! scene with unit names
    character(len=:), allocatable :: text  !! one line

    text = 'length ' // unit_of(scene_in, is_length) // ', force ' // &
           unit_of(scene_in, is_force) // ', area ' // unit_of(scene_in, is_area) // &
           ', pressure ' // unit_of(scene_in, is_pressure)
  end function units_in_words

  !> Dimension of a quantity whose unit holds the modulus and the length to some powers.
  pure integer function dimension_of(powers) result(dimension)
    integer, intent(in) :: powers(2)  !! of the modulus, of the length
    integer, parameter :: known(2, is_number:is_moment) = &
      reshape([0, 0, 0, 1, 1, 2, 0, 2, 1, 0, 1, 3], [2, 6])

    do dimension = is_moment, is_number + 1, -1
      if (all(known(:, dimension) == powers)) return
    end do
  end function dimension_of

  !> Unit of a dimension in the units of the scene; empty where it has none.
  pure function unit_of(scene_in, dimension) result(unit)
    type(scene), intent(in) :: scene_in    !! with or without units
    integer, intent(in) :: dimension       !! one of the `is_` numbers
    character(len=:), allocatable :: unit  !! for instance `mm2`, `MPa`, `N/cm2`
    character(len=:), allocatable :: length, force
    ! Length, force, and the name of a force on their area.
    character(len=*), parameter :: named(3, 5) = reshape([character(len=3) :: &
      'mm', 'N', 'MPa', 'um', 'uN', 'MPa', 'm', 'N', 'Pa', 'um', 'mN', 'GPa', 'nm', 'nN', 'GPa'], &
      [3, 5])
    integer :: known

    length = length_unit(scene_in)
    force = trim(scene_in%units(2))
    unit = ''
    if (dimension == is_length) unit = length
    if (dimension == is_force) unit = force
    if (dimension == is_area .and. length /= '') unit = length // '2'
    if (dimension == is_pressure .and. force /= '') then
      unit = force // '/' // length // '2'
      known = findloc(named(1, :) == length .and. named(2, :) == force, .true., 1)
      if (known > 0) unit = trim(named(3, known))
    end if
    if (dimension == is_moment .and. force /= '') unit = force // ' ' // length
  end function unit_of

  ! Unit of length of the scene, or of its height map; empty where neither has one.
  pure function length_unit(scene_in) result(unit)
    type(scene), intent(in) :: scene_in
    character(len=:), allocatable :: unit

    unit = trim(scene_in%units(1))
    if (unit /= '' .or. .not. allocated(scene_in%map)) return
    unit = trim(scene_in%map%lower%unit)
    if (scene_in%map%lower%columns == 0) unit = trim(scene_in%map%upper%unit)
  end function length_unit

  !> A name and its unit in brackets; the name alone where there is none.
  pure function with_unit(name, unit) result(text)
    character(len=*), intent(in) :: name   !! of a quantity
    character(len=*), intent(in) :: unit   !! its name, or blank
    character(len=:), allocatable :: text  !! for instance `load (N)`

    text = name
    if (unit /= '') text = name // ' (' // trim(unit) // ')'
  end function with_unit

  !> Unit of a drawing's axis: the name of the quantity where the unit has none.
  pure function axis_unit(scene_in, dimension) result(unit)
    type(scene), intent(in) :: scene_in    !! what was solved
    integer, intent(in) :: dimension       !! one of the `is_` numbers
    character(len=20) :: unit              !! blank for a plain number
    character(len=*), parameter :: words(is_number:is_moment) = [character(len=7) :: '', &
      'length', 'force', 'length2', '', '']

    unit = unit_of(scene_in, dimension)
    if (unit == '') unit = words(dimension)
  end function axis_unit

end module asperity_unit_names
