!> Reads what `asperity study` shall study: text in, checked values or a list of problems out.
!>
!> The text is a specification of random surfaces (`asperity_generation_spec`) with two groups more,
!> &material and &study.
module asperity_study_spec
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_file_kind, only: a_specification, a_study
  use asperity_generation_spec, only: generation_table, take_generation
  use asperity_generation_values, only: generation_spec
  use asperity_input_text, only: read_text
  use asperity_kinds, only: real64
  use asperity_numeral, only: above_zero, any_number, poisson_range, share
  use asperity_problems, only: problem_list
  use asperity_scene_fields, only: read_fields, scene_fields
  use asperity_scene_names, only: in_group
  implicit none
  private

  public :: study_spec, read_study_spec
  public :: against_plane, places_grid, places_random, reference_integral, reference_largest

  integer, parameter :: most_sections = 1000  !! sections of one size on one surface at most
  integer, parameter :: most_sizes = 20       !! sizes at most

  integer, parameter :: against_surface = 1   !! the upper surface meets the lower one
  integer, parameter :: against_plane = 2     !! it meets a plane of the lower one's material
  !> Their words.
  character(len=*), parameter :: against_words(2) = [character(len=7) :: 'surface', 'plane']

  integer, parameter :: places_grid = 1       !! sections side by side
  integer, parameter :: places_random = 2     !! sections anywhere
  !> Their words.
  character(len=*), parameter :: places_words(2) = [character(len=6) :: 'grid', 'random']

  integer, parameter :: reference_integral = 1  !! sections are compared with the integral
  integer, parameter :: reference_largest = 2   !! compared with the mean of the largest size
  !> Their words.
  character(len=*), parameter :: reference_words(2) = [character(len=8) :: 'integral', 'largest']

  !> A whole study.
  type :: study_spec
    type(generation_spec) :: surfaces                  !! the ensemble
    character(len=:), allocatable :: text              !! the file itself
    type(decimal_value) :: elastic_modulus(2)          !! upper, lower; more than 0
    type(decimal_value) :: poisson_ratio(2)            !! upper, lower
    integer :: against = against_surface               !! what the upper surface meets
    logical :: at_pressure = .false.                   !! the pressure is given
    type(decimal_value) :: separation                  !! of the reference planes, else
    type(decimal_value) :: pressure                    !! vertical load on an area, more than 0
    real(real64), allocatable :: sizes(:)              !! sides of sections, descending; may be
                                                       !! empty: then from the whole down
    real(real64) :: factor = 2.0_real64                !! from one size to the next, more than 1
    integer :: steps = 6                               !! how many sizes
    integer :: sections = 100                          !! of a size on a surface, at most
    integer :: places = places_grid                    !! where they are
    integer :: reference = reference_integral          !! what a section is compared with
    real(real64) :: tolerance = 0.1_real64             !! how near it must be, share of that
    real(real64) :: confidence = 0.95_real64           !! share of the sections that must be
  end type study_spec

contains

  !> Reads and checks a specification. With problems it is not to be used.
  subroutine read_study_spec(path, spec, problems)
    character(len=*), intent(in) :: path         !! path of the specification; `-` is standard input
    type(study_spec), intent(out) :: spec        !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong
    type(scene_fields) :: fields

    spec%surfaces%file = path
    call read_text(path, 'a specification', spec%text, problems)
    if (problems%count() > 0) return
    call read_fields(path, spec%text, 'a specification', [a_specification, a_study], &
                     [generation_table(), in_group('material', [character(len=15) :: &
                      'elastic_modulus', 'poisson_ratio']), in_group('study', [character(len=10) &
                      :: 'separation', 'pressure', 'against', 'sizes', 'factor', 'steps', &
                      'sections', 'places', 'reference', 'tolerance', 'confidence'])], fields)
    if (fields%is_text) call take_study(fields, spec)
    problems = fields%problems
    spec%surfaces%notes = fields%notes
  end subroutine read_study_spec

  !> All groups.
  subroutine take_study(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(study_spec), intent(inout) :: spec

    call take_generation(fields, spec%surfaces)
    if (spec%surfaces%is_deck) &
      call fields%complain_of_group('deck', 'group &deck: found in a study, expected none')
    if (fields%has_name('random', 'ensemble') .and. spec%surfaces%ensemble < 2) &
      call fields%complain_of('random', 'ensemble', 'found fewer than 2 surfaces, expected ' // &
                              '2 or more, as their spread is studied')
    call fields%require_name('random', 'ensemble', 'the number of surfaces, 2 or more')
    call fields%require_name('material', 'elastic_modulus', 'two values, or one for both surfaces')
    call fields%require_name('material', 'poisson_ratio', 'two values, or one for both surfaces')
    call fields%take_pair('material', 'elastic_modulus', above_zero, spec%elastic_modulus)
    call fields%take_pair('material', 'poisson_ratio', poisson_range, spec%poisson_ratio)
    call take_loading(fields, spec)
    call take_sections(fields, spec)
  end subroutine take_study

  !> How near the surfaces come.
  subroutine take_loading(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(study_spec), intent(inout) :: spec

    call fields%take_word('study', 'against', against_words, spec%against)
    call fields%take_number('study', 'separation', any_number, spec%separation)
    call fields%take_number('study', 'pressure', above_zero, spec%pressure)
    spec%at_pressure = fields%has_name('study', 'pressure')
    if (spec%at_pressure .and. fields%has_name('study', 'separation')) then
      call fields%complain_of('study', 'separation', 'found beside pressure, expected one of them')
    else if (.not. spec%at_pressure .and. .not. fields%has_name('study', 'separation')) then
      call fields%complain_of_group('study', 'no separation and no pressure in &study, ' // &
                                    'expected one of them')
    end if
  end subroutine take_loading

  !> Takes how sections are cut out, and when one is representative.
  subroutine take_sections(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(study_spec), intent(inout) :: spec
    type(decimal_value), allocatable :: sizes(:)
    integer :: number

    number = fields%value_count('study', 'sizes')
    allocate (sizes(min(number, most_sizes)))
    call fields%take_numbers('study', 'sizes', above_zero, sizes)
    spec%sizes = decimal_to_real64(sizes)
    if (number <= most_sizes .and. all(sizes%all_digits > 0)) then
      if (.not. all(spec%sizes(2:) < spec%sizes(:number - 1))) &
        call fields%complain_of('study', 'sizes', 'found sizes in another order, expected ' // &
                                'each to be smaller than the one before')
    end if
    if (number > 0 .and. fields%has_name('study', 'factor')) &
      call fields%complain_of('study', 'factor', 'found beside sizes, expected one of them')
    if (number > 0 .and. fields%has_name('study', 'steps')) &
      call fields%complain_of('study', 'steps', 'found beside sizes, expected one of them')
    call take_real(fields, 'factor', above_zero, spec%factor)
    if (.not. spec%factor > 1.0_real64) &
      call fields%complain_of('study', 'factor', 'found 1 or less, expected a number more than 1')
    call fields%take_whole('study', 'steps', 1, most_sizes, spec%steps)
    call fields%take_whole('study', 'sections', 1, most_sections, spec%sections)
    call fields%take_word('study', 'places', places_words, spec%places)
    call fields%take_word('study', 'reference', reference_words, spec%reference)
    call take_real(fields, 'tolerance', share, spec%tolerance)
    call take_real(fields, 'confidence', share, spec%confidence)
  end subroutine take_sections

  !> A number of &study as a double; it stays as it is when it is not there or not good.
  subroutine take_real(fields, name, number_range, number)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: name
    integer, intent(in) :: number_range
    real(real64), intent(inout) :: number
    type(decimal_value) :: value

    call fields%take_number('study', name, number_range, value)
    if (value%all_digits /= 0) number = decimal_to_real64(value)
  end subroutine take_real

end module asperity_study_spec
