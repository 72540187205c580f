!> From the file of a height map to its summits: reading, unit, levelling, removal of outliers.
module asperity_summits_of_file
  use asperity_height_map, only: check_spacing, give_spacing, height_map, is_measured, &
                                 length_units, level_names, level_plane, note_repeated_line, &
                                 periodic_edge, put_in_unit, usual_level
  use asperity_height_map_reader, only: read_height_map
  use asperity_kinds, only: int64, real64
  use asperity_map_despiking, only: despike_map
  use asperity_map_levelling, only: level_map
  use asperity_map_summits, only: find_summits, map_summits, rule_eight, rule_names, usual_radius
  use asperity_problems, only: decimal_text, problem_list
  use asperity_summit_spheres, only: radius_names
  implicit none
  private

  public :: summit_choices, summits_of_file, summits_of_array, summits_of_samples

  !> Options of the search for summits.
  type :: summit_choices
    integer :: rule = rule_eight               !! rule for summits, one of `rule_names`
    logical :: periodic = .false.              !! the map repeats itself
    logical :: edge_of_file = .false.          !! it does also where the file has that
    integer :: level = 0                       !! rule for levelling; 0: the default
    integer :: radius = 0                      !! rule for radii; 0: default of the rule for summits
    integer :: unit = 0                        !! of `length_units`; 0: the file's own
    logical :: despike = .false.               !! replace single outliers
    real(real64) :: pixel_spacing(2) = 0.0_real64  !! pixel spacing of a matrix; 0: not given
    logical :: progress = .false.              !! print the progress on a terminal
    character(len=2) :: prefix = ''            !! prefix of option names in messages: `--`, or none
  end type summit_choices

contains

  !> Reads a map and finds its summits. Neither is valid with problems, or when `failure` is
  !> allocated because memory is short.
  subroutine summits_of_file(path, choices, map, summits, spikes, problems, failure)
    character(len=*), intent(in) :: path                    !! path of the file
    type(summit_choices), intent(inout) :: choices          !! options; defaults are filled in
    type(height_map), intent(out) :: map                    !! levelled height map
    type(map_summits), intent(out) :: summits               !! summits of the map
    integer(int64), intent(out) :: spikes                   !! number removed; -1: not searched for
    type(problem_list), intent(inout) :: problems           !! faults of the options or the file
    character(len=:), allocatable, intent(out) :: failure   !! reason, when memory is short

    spikes = -1_int64
    call check_choices(choices, problems)
    if (problems%count() > 0) return
    call read_height_map(path, choices%pixel_spacing, choices%progress, map, problems, failure, &
                         trim(choices%prefix) // 'spacing', choices%unit)
    if (problems%count() > 0 .or. allocated(failure)) return
    if (choices%edge_of_file .and. map%edge == periodic_edge) choices%periodic = .true.
    call check_choices(choices, problems)
    if (problems%count() > 0) return
    call put_in_unit(map, choices%unit)
    call summits_of_samples(map, choices, summits, spikes, failure)
    if (allocated(failure)) failure = path // ': ' // failure
  end subroutine summits_of_file

  !> Finds the summits of a map in memory, whose edge replaces that of the options.
  subroutine summits_of_array(map, choices, summits, spikes, problems, failure)
    type(height_map), intent(inout) :: map                  !! map of take_map; levelled on exit
    type(summit_choices), intent(inout) :: choices          !! options; defaults are filled in
    type(map_summits), intent(out) :: summits               !! summits of the map
    integer(int64), intent(out) :: spikes                   !! number removed; -1: not searched for
    type(problem_list), intent(inout) :: problems           !! faults of the options or the file
    character(len=:), allocatable, intent(out) :: failure   !! reason, when memory is short
    character(len=:), allocatable :: fault

    spikes = -1_int64
    choices%periodic = map%edge == periodic_edge
    call check_choices(choices, problems)
    call check_spacing(choices%pixel_spacing, trim(choices%prefix) // 'spacing', fault)
    if (fault == '') &
      call give_spacing(map, choices%pixel_spacing, trim(choices%prefix) // 'spacing', .false., &
      fault)
    if (fault /= '') call problems%add(fault)
    if (problems%count() > 0) return
    call put_in_unit(map, choices%unit)
    call summits_of_samples(map, choices, summits, spikes, failure)
  end subroutine summits_of_array

  ! Reports options that are out of range.
  subroutine check_choices(choices, problems)
    type(summit_choices), intent(inout) :: choices
    type(problem_list), intent(inout) :: problems

    if (choices%periodic .and. choices%level == level_plane) &
      call problems%add(trim(choices%prefix) // &
                        'level: a periodic map without its plane would ' // &
                        'not be periodic: found plane, expected mean or none')
    call check_choice('rule', choices%rule, 1, size(rule_names))
    call check_choice('level', choices%level, 0, size(level_names))
    call check_choice('radius', choices%radius, 0, size(radius_names))
    call check_choice('unit', choices%unit, 0, size(length_units))

  contains

    subroutine check_choice(name, choice, least, most)
      character(len=*), intent(in) :: name
      integer, intent(in) :: choice, least, most

      if (choice < least .or. choice > most) &
        call problems%add(name // ': found ' // decimal_text(choice) // ', expected a number ' // &
                          'from ' // decimal_text(least) // ' to ' // decimal_text(most))
    end subroutine check_choice

  end subroutine check_choices

  !> Levels a map, replaces outliers if chosen and finds the summits.
  subroutine summits_of_samples(map, choices, summits, spikes, failure)
    type(height_map), intent(inout) :: map                  !! read, then levelled
    type(summit_choices), intent(inout) :: choices          !! options; defaults are filled in
    type(map_summits), intent(out) :: summits               !! summits of the map
    integer(int64), intent(out) :: spikes                   !! number removed; -1: not searched for
    character(len=:), allocatable, intent(out) :: failure   !! reason, when memory is short

    real(real64), parameter :: missing_noted = 0.01_real64  ! share without a note (chosen)
    real(real64) :: missing

    spikes = -1_int64
    if (choices%level == 0) choices%level = usual_level(choices%periodic)
    map%periodic = choices%periodic
    call note_repeated_line(map)
    missing = 1.0_real64 - count(is_measured(map%height), kind=int64) / real(size(map%height, &
      kind=int64), real64)
    if (missing > missing_noted) call map%notes%add_in_file('note: ' // &
      decimal_text(nint(100 * missing)) // ' % of the pixels are missing: slopes and moments ' // &
      'leave out the rims of holes')
    call level_map(map, choices%level)
    if (choices%despike) call despike_map(map, choices%level, choices%progress, spikes, failure)
    if (choices%radius == 0) choices%radius = usual_radius(choices%rule)
    if (.not. allocated(failure)) &
      call find_summits(map, choices%rule, choices%radius, summits, failure)
  end subroutine summits_of_samples

end module asperity_summits_of_file
