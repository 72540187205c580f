!> Letters as dots, 5 x 7 each, for pictures that are pixels: the printable characters of ASCII, in
!> the shapes of dot-matrix displays.
module asperity_pixel_font
  implicit none
  private

  public :: has_dot
  public :: glyph_height, glyph_width

  !> Dots of a letter down and across.
  integer, parameter :: glyph_height = 7, glyph_width = 5

  ! Two hexadecimal digits a column of dots, the lowest bit at the top; from blank to tilde.
  character(len=*), parameter :: dots = &
    '000000000000005F00000007000700147F147F14242A7F2A12231308646236495620500008070300' // &
    '001C2241000041221C0014083E081408083E08080050300000080808080800606000002010080402' // &
    '3E5149453E00427F400042615149462141454B311814127F1027454545393C4A4949300171090503' // &
    '3649494936064949291E003636000000563600000814224100141414141400412214080201510906' // &
    '324979413E7E1111117E7F494949363E414141227F4141221C7F494949417F090909013E4149497A' // &
    '7F0808087F00417F41002040413F017F081422417F404040407F020C027F7F0408107F3E4141413E' // &
    '7F090909063E4151215E7F09192946464949493101017F01013F4040403F1F2040201F3F4038403F' // &
    '631408146307087008076151494543007F41410002040810200041417F0004020102044040404040' // &
    '000102040020545454787F484444383844444420384444487F3854545418087E0901020C5252523E' // &
    '7F0804047800447D40002040443D007F1028440000417F40007C041804787C080404783844444438' // &
    '7C14141408081414187C7C080404084854545420043F4440203C4040207C1C2040201C3C4030403C' // &
    '44281028440C5050503C4464544C44000836410000007F000000413608000804081008'

contains

  !> Whether a letter has a dot at a place; letters outside of ASCII are question marks.
  pure logical function has_dot(letter, column, row)
    character(len=1), intent(in) :: letter  !! any byte
    integer, intent(in) :: column           !! from 1 at the left to `glyph_width`
    integer, intent(in) :: row              !! from 1 at the top to `glyph_height`
    integer :: at, bits, number

    number = iachar(letter)
    if (number < 32 .or. number > 126) number = iachar('?')
    at = 2 * (glyph_width * (number - 32) + column) - 1
    bits = 16 * digit(dots(at:at)) + digit(dots(at + 1:at + 1))
    has_dot = btest(bits, row - 1)
  end function has_dot

  pure integer function digit(letter)
    character(len=1), intent(in) :: letter

    digit = index('0123456789ABCDEF', letter) - 1
  end function digit

end module asperity_pixel_font
