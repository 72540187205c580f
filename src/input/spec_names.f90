!> The names of the specifications of `asperity generate`, one row each.
module asperity_spec_names
  use asperity_generation_values, only: below_words, most_asperities
  use asperity_height_map, only: length_units
  use asperity_kinds, only: real64
  use asperity_numeral, only: a_length, above_zero, any_number, not_negative, poisson_range, &
                              share_or_all
  use asperity_scene_fields, only: known_name, most_words, one_word, whole_number, whole_value, &
                                   word_length
  implicit none
  private

  public :: spec_table


  ! Pixels along a side: more would leave too few bits for a wave number's square.
  integer, parameter :: most_pixels = 1048576
  character(len=*), parameter :: none(most_words - 2) = ''
  integer, parameter :: pair(2) = [1, 2]  ! one value for both surfaces, or both directions, or two
  real(real64), parameter :: one = 1.0_real64  ! also: the first word

  !> A row each.
  type(known_name), parameter :: spec_table(*) = [ &
    known_name('surfaces', 'number', whole_value, 'this or density is needed', pair, &
               otherwise='needed', least=1, most=most_asperities), &
    known_name('surfaces', 'density', above_zero, &
               'in place of number: asperities per area, rounded to an integer', pair, &
               beside='number'), &
    known_name('surfaces', 'length', above_zero, 'extent along x', pair, otherwise='needed'), &
    known_name('surfaces', 'width', above_zero, 'extent along y', pair, otherwise='needed'), &
    known_name('surfaces', 'least_distance', not_negative, 'between two summits in plan', pair), &
    known_name('heights', 'mean', any_number, 'before truncation', pair, otherwise='needed'), &
    known_name('heights', 'deviation', not_negative, 'standard deviation before truncation', &
               pair, otherwise='needed'), &
    known_name('heights', 'lowest', any_number, 'truncation', pair, otherwise='none'), &
    known_name('heights', 'highest', any_number, 'truncation', pair, otherwise='none'), &
    known_name('heights', 'lowest_deviation', any_number, 'truncation in deviations', pair, &
               otherwise='none', beside='lowest'), &
    known_name('heights', 'highest_deviation', any_number, 'truncation in deviations', pair, &
               otherwise='none', beside='highest'), &
    known_name('radii', 'mean', above_zero, 'before truncation', pair, otherwise='needed'), &
    known_name('radii', 'deviation', not_negative, 'standard deviation before truncation', pair), &
    known_name('radii', 'lowest', above_zero, 'truncation', pair), &
    known_name('radii', 'highest', above_zero, 'truncation', pair), &
    known_name('radii', 'lowest_deviation', any_number, 'truncation in deviations', pair, &
               otherwise='none', beside='lowest'), &
    known_name('radii', 'highest_deviation', any_number, 'truncation in deviations', pair, &
               otherwise='none', beside='highest'), &
    known_name('random', 'seed', whole_number, 'of the random numbers', default=one, &
               least=0, most=huge(0)), &
    known_name('random', 'ensemble', whole_number, 'number of surfaces of each side', &
               default=one, least=1, most=1000000), &
    known_name('random', 'tries', whole_number, 'places tried at most for one asperity', &
               default=10000.0_real64, least=1, most=1000000), &
    known_name('deck', 'elastic_modulus', above_zero, 'upper, lower; psi', pair, &
               otherwise='needed'), &
    known_name('deck', 'poisson_ratio', poisson_range, 'upper, lower', pair, &
               otherwise='needed'), &
    known_name('deck', 'allowed_stress', not_negative, 'upper, lower; psi', pair, &
               otherwise='needed'), &
    known_name('deck', 'rotation', any_number, 'radians', pair), &
    known_name('deck', 'lower_width', above_zero, 'WIDTHL', &
               otherwise='the width of the lower surface'), &
    known_name('deck', 'x_displacement', any_number, 'XDISPL'), &
    known_name('deck', 'y_displacement', any_number, 'YDISPL'), &
    known_name('map', 'pixels', whole_value, 'columns and rows', pair, otherwise='needed', &
               least=3, most=most_pixels), &
    known_name('map', 'spacing', a_length, 'of pixels along x and y', pair, otherwise='needed'), &
    known_name('map', 'hurst', share_or_all, 'Hurst exponent', otherwise='needed'), &
    known_name('map', 'roll_off', above_zero, &
               'wavelength above which the spectrum is no power law', &
               otherwise='the shorter side'), &
    known_name('map', 'cut_off', above_zero, 'shortest wavelength', &
               otherwise='two of the larger spacing'), &
    known_name('map', 'rms_height', a_length, 'this or rms_slope is needed'), &
    known_name('map', 'rms_slope', a_length, 'rms slope of the gradient', &
               beside='rms_height'), &
    known_name('map', 'seed', whole_number, 'of the random numbers', default=one, &
               least=0, most=huge(0)), &
    known_name('map', 'periodic', one_word, 'off: a part of a larger periodic map', default=one, &
               words=[character(len=word_length) :: 'on', 'off', none]), &
    known_name('map', 'below_roll_off', one_word, 'spectrum at wavelengths above the roll-off', &
               default=one, words=[character(len=word_length) :: below_words, none]), &
    known_name('map', 'unit', one_word, 'of all lengths', &
               words=[character(len=word_length) :: length_units, none(5:)])]

end module asperity_spec_names
